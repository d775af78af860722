"""Several recordings may be held out: all of them judge, none is fitted."""

from collections.abc import Callable
from pathlib import Path

import pytest

from ident.commands.diagnose import command
from ident.diagnose import answer
from ident.diagnose.diagnosis import Choices, question
from ident.effects import library
from recordings.errors import BadInput
from recordings.recording import Recording


def test_all_judge_and_none_is_fitted(
    make: Callable[..., Recording], write: Callable[[Recording], Path], tmp_path: Path
) -> None:
    made = {"a": "fig5a", "b": "fig5b", "c": "excitation"}
    files = [
        write(make(trajectory, rate=250.0, cycles=2, noise=0.01, path=tmp_path / f"{name}.mcap"))
        for name, trajectory in made.items()
    ]
    material = question(files[:1], files[1:], library(), Choices()).material
    assert [bool(seen.any()) for seen in material.seen] == [True, False, False]
    assert [bool(held.any()) for held in material.held] == [False, True, True]
    assert answer.held_out(material) == "other recordings: b.mcap, c.mcap"
    alone = question(files[:1], files[1:2], library(), Choices()).material
    assert answer.held_out(alone) == "another recording: b.mcap"


def test_a_model_is_judged_on_one(tmp_path: Path) -> None:
    arguments = ["a.mcap", "--validate", "b.mcap", "--validate", "c.mcap", "--apply"]
    with pytest.raises(BadInput, match="one --validate"):
        command.main([*arguments, "-o", str(tmp_path / "m.json")], standalone_mode=False)
