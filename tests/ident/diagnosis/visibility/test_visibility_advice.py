"""Reasons why recordings do not show an effect, and what to record."""

import shlex
from dataclasses import replace
from pathlib import Path

import pytest

from ident.data.recording_facts import RecordingFacts, recording_facts
from ident.diagnosis.visibility.visibility import SmallestSize, Visibility
from ident.diagnosis.visibility.visibility_advice import Adviser
from ident.dynamics.effects.library import library
from recordings.recording import Recording
from tests.ident import building

RECORDING = replace(building.record(noise=0.01), path=Path("a b.mcap"))
SMALLEST = SmallestSize(share=0.004, parameter="a", value=0.5, unit="N m")
FACTS = recording_facts([building.prepared(RECORDING)])


def adviser(facts: RecordingFacts = FACTS, recording: Recording = RECORDING) -> Adviser:
    return Adviser(facts, [recording], library(), 0.03)


def visible(name: str, *imitations: str) -> Visibility:
    return Visibility(effect=name, status="visible", joints=(1,), confusable_with=imitations, smallest=SMALLEST)


def hidden(name: str, smallest: SmallestSize | None = SMALLEST) -> Visibility:
    return Visibility(effect=name, status="not-visible", smallest=smallest, outside=0.05)


def facts(**changes: float) -> RecordingFacts:
    return replace(FACTS, joints=(replace(FACTS.joints[0], **changes),))


def test_a_visible_effect_needs_nothing() -> None:
    advice = adviser().advice(visible("stribeck"))
    assert advice.why == "It shows from 0.4 % of the torque (a = 0.5 N m, joint 1) on."
    assert (advice.record, advice.command) == (None, None)


def test_effects_that_look_alike_take_a_motion_that_tells_them_apart() -> None:
    advice = adviser().advice(visible("axis_weight", "joint_spring", "thermal_drift"))
    assert "joint_spring, thermal_drift would explain as much of 3 %" in advice.why
    assert shlex.split(advice.command or "") == [
        *("ident", "design", "--discriminate", "axis_weight", "joint_spring"),
        *("--recording", "a b.mcap", "-o", "next.toml"),
    ]


def test_no_motion_tells_an_effect_from_one_that_changes_with_time() -> None:
    advice = adviser().advice(visible("thermal_drift", "axis_weight"))
    assert advice.command is None
    assert "at the machine" in (advice.record or "")


@pytest.mark.parametrize(
    ("name", "changes", "expected"),
    [
        ("stribeck", {"forward_share": 1.0}, "Hardly a reversal."),
        ("quadratic_friction", {"speed_spread": 0.01}, "Hardly more than one speed."),
        ("load_dependent_friction", {"torque_spread": 0.05}, "The load hardly changes."),
        ("joint_spring", {"travel": 0.05}, "The joint hardly moves."),
        ("thermal_drift", {}, "The recording lasts 16 s only."),
    ],
)
def test_the_reason_is_what_the_motion_lacks(name: str, changes: dict[str, float], expected: str) -> None:
    advice = adviser(facts(**changes)).advice(hidden(name))
    assert advice.why.startswith(expected)
    assert advice.record


@pytest.mark.parametrize(
    ("smallest", "expected"),
    [(SMALLEST, "0.4 % of the torque (a = 0.5 N m, joint 1)"), (None, "larger than hardware has it")],
)
def test_a_good_motion_hides_an_effect_in_noise_and_in_other_parameters(
    smallest: SmallestSize | None, expected: str
) -> None:
    advice = adviser().advice(hidden("stribeck", smallest))
    assert f"it would have to be {expected}: other parameters of the model reproduce all but 5 %" in advice.why
    assert advice.command == "ident design --with stribeck --recording 'a b.mcap' -o next.toml"


def test_drift_takes_a_longer_recording_of_a_known_trajectory() -> None:
    run = RECORDING.run.model_copy(update={"trajectory": "fig5a", "cycles": 2})
    command = adviser(recording=replace(RECORDING, run=run)).advice(hidden("thermal_drift")).command
    assert command == "daq record --traj fig5a --cycles 20"
    assert adviser().advice(hidden("thermal_drift")).command is None


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("temperature_friction", "temperature_1"),
        ("back_emf", "voltage_1"),
        ("position_dependent_friction", "both directions"),
        ("encoder_eccentricity", None),
    ],
)
def test_what_a_recording_lacks_is_recorded_unless_hardware_excludes_it(name: str, expected: str | None) -> None:
    advice = adviser().not_recorded(name, "Because.")
    assert advice.why == "Because."
    assert expected in (advice.record or "") if expected else advice.record is None
