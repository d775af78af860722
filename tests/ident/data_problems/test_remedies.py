"""The remedy of a data problem, pasted, gives the clean recording."""

import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from daq.program import program
from recordings.reader import read
from recordings.recording import Recording
from tests.ident.conftest import write_recording
from tests.ident.data_problems.test_mistakes import MISTAKES, problems_of, robot

HEALED = [name for name, mistake in MISTAKES.items() if mistake.remedy.startswith("--")]


def remedy_of(recording: Recording) -> list[str]:
    """Words of the command that is proposed."""
    (problem,) = problems_of(recording)
    return shlex.split(problem.remedy)


@pytest.mark.parametrize("mistake", HEALED)
def test_the_remedy_gives_the_clean_recording(mistake: str, tmp_path: Path) -> None:
    clean = robot(3)
    file = write_recording(replace(MISTAKES[mistake].change(clean), path=tmp_path / "run.mcap"))
    words = remedy_of(read(file))
    done = CliRunner().invoke(program, words[1:], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    healed = read(tmp_path / "run-healed.mcap")
    assert problems_of(healed) == []
    assert healed.effort is not None
    assert clean.effort is not None
    if mistake == "held":
        assert len(healed.time) == pytest.approx(len(clean.time) / 5, abs=1)
        assert healed.run.rate == clean.run.rate / 5
        return
    known = np.isfinite(healed.effort)
    zero = np.nanmedian(healed.position - clean.position, axis=0)  # an angle within a turn has lost its zero
    np.testing.assert_allclose(healed.position - zero, clean.position, atol=1e-9)
    np.testing.assert_allclose(healed.effort[known], clean.effort[known], rtol=1e-6, atol=1e-6)
    assert known.mean() > 0.99
    assert (healed.rig.name, healed.run.trajectory) == (clean.rig.name, clean.run.trajectory)
