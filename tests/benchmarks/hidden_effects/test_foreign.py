"""Recordings of cases of the foreign plant."""

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.hidden_effects import foreign
from benchmarks.hidden_effects.cases import HiddenCase
from recordings.errors import BadInput
from recordings.reader import read

TOO_SLOW = HiddenCase("foreign", "single", ("actuation_delay",), (0.03,), "any", 10, "chosen", rate=100.0)
"""A case whose first robot cannot have a delay of this size."""


def test_conditions_of_the_case_are_those_of_the_recording(tmp_path: Path) -> None:
    case = HiddenCase("foreign", "nothing", (), (), "any", 1, rate=125.0, repeats=False, signal="effort")
    assert foreign.record(case, tmp_path)["effects"] == []
    recording = read(tmp_path / "train.mcap")
    assert recording.run.rate == pytest.approx(125.0)
    assert recording.effort is not None
    assert recording.repeat.max() == -1


def test_another_robot_is_drawn_if_the_effect_cannot_have_its_size(tmp_path: Path) -> None:
    truth = foreign.record(TOO_SLOW, tmp_path)
    assert truth["seed"] > TOO_SLOW.seed
    assert truth["effects"][0]["size"] == pytest.approx(0.03, rel=0.1)


def test_tuned_case_keeps_its_robot(tmp_path: Path) -> None:
    invisible = replace(TOO_SLOW, effects=("amplifier_deadband",), robot="default", part="tuned")
    with pytest.raises(BadInput, match="choose another"):
        foreign.record(invisible, tmp_path)
