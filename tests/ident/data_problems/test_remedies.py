"""The remedy of a data problem, pasted, gives the clean recording."""

import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from daq.program import program
from recordings.reader import read
from recordings.recording import Recording
from tests.ident.conftest import write_recording
from tests.ident.data_problems.test_mistakes import MISTAKES, problems_of, robot
from tests.running import first_fast, printed

HEALED = [name for name, mistake in MISTAKES.items() if mistake.remedy.startswith("--")]


def healed_by(recording: Recording) -> Path:
    """Do what is proposed; return what it wrote."""
    (problem,) = problems_of(recording)
    words = shlex.split(problem.remedy)
    printed(program, *words[1:])
    return Path(words[words.index("--out") + 1])


@pytest.mark.parametrize("mistake", first_fast(HEALED))
def test_the_remedy_gives_the_clean_recording(mistake: str, tmp_path: Path) -> None:
    clean = robot(3)
    file = write_recording(replace(MISTAKES[mistake].change(clean), path=tmp_path / "run.mcap"))
    healed = read(healed_by(read(file)))
    assert problems_of(healed) == []
    assert healed.effort is not None
    assert clean.effort is not None
    if mistake == "held":
        assert len(healed.time) == pytest.approx(len(clean.time) / 5, abs=1)
        assert (healed.run.rate, healed.run.torque_window) == (clean.run.rate / 5, 1 / clean.run.rate)
        return
    known = np.isfinite(healed.effort)
    turns = np.rint((healed.position[0] - clean.position[0]) / (2 * np.pi))  # which of them, no encoder of one tells
    np.testing.assert_allclose(healed.position - 2 * np.pi * turns, clean.position, atol=1e-9)
    np.testing.assert_allclose(healed.effort[known], clean.effort[known], rtol=1e-6, atol=1e-6)
    assert known.mean() > 0.99
    assert (healed.rig.name, healed.run.trajectory) == (clean.rig.name, clean.run.trajectory)
