"""Several recordings may be held out: all of them judge, none is fitted."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from ident.commands.diagnose import command
from ident.diagnosis import answer
from ident.diagnosis.diagnosis import DiagnosisOptions, diagnose, prepare_inputs
from ident.dynamics.effects.library import library
from recordings.errors import BadInput
from recordings.recording import Recording
from tests.ident.conftest import TRUTH


def test_all_judge_and_none_is_fitted(
    make: Callable[..., Recording], write: Callable[[Recording], Path], tmp_path: Path
) -> None:
    made = {"a": "fig5a", "b": "fig5b", "c": "excitation"}
    files = [
        write(make(trajectory, rate=250.0, cycles=2, noise=0.01, path=tmp_path / f"{name}.mcap"))
        for name, trajectory in made.items()
    ]
    material = prepare_inputs(files[:1], files[1:], library(), DiagnosisOptions()).split
    assert [bool(seen.any()) for seen in material.train] == [True, False, False]
    assert [bool(held.any()) for held in material.test] == [False, True, True]
    assert answer.describe_test_data(material) == "other recordings: b.mcap, c.mcap"
    alone = prepare_inputs(files[:1], files[1:2], library(), DiagnosisOptions()).split
    assert answer.describe_test_data(alone) == "another recording: b.mcap"


def test_a_model_is_judged_on_one(tmp_path: Path) -> None:
    arguments = ["a.mcap", "--validate", "b.mcap", "--validate", "c.mcap", "--apply"]
    with pytest.raises(BadInput, match="one --validate"):
        command.main([*arguments, "-o", str(tmp_path / "m.json")], standalone_mode=False)


def test_what_was_fitted_is_no_validation(
    make: Callable[..., Recording], write: Callable[[Recording], Path], tmp_path: Path
) -> None:
    file = write(make("fig5a", rate=250.0, cycles=2, path=tmp_path / "a.mcap"))
    with pytest.raises(BadInput, match="holds the same data"):
        prepare_inputs([file], [file], library(), DiagnosisOptions())


def test_recordings_that_disagree_are_named(
    make: Callable[..., Recording], write: Callable[[Recording], Path], tmp_path: Path
) -> None:
    (tmp_path / "other").mkdir()
    changed = TRUTH * np.where(np.arange(len(TRUTH)) == 0, 1.2, 1.0)
    files = [
        write(make("fig5a", rate=250.0, cycles=2, noise=0.01, path=tmp_path / "a.mcap")),
        write(make("fig5b", rate=250.0, cycles=2, noise=0.01, path=tmp_path / "b.mcap")),
        write(
            make("fig5b", rate=250.0, cycles=2, noise=0.01, parameters=changed, path=tmp_path / "other" / "b.mcap")
        ),
    ]
    none = {"rod_inertia": library()["rod_inertia"]}
    found = answer.to_document(diagnose(files[:1], files[1:], none, DiagnosisOptions()))
    (caution,) = [one for one in found.cautions if "disagree" in one]
    assert f"{tmp_path / 'b.mcap'}: 1" in caution
    assert str(tmp_path / "other" / "b.mcap") in found.held_out
    alone = answer.to_document(diagnose(files[:1], files[1:2], none, DiagnosisOptions()))
    assert not [one for one in alone.cautions if "disagree" in one]
