"""Reasons why recordings do not show an effect, and what to record."""

import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ident.data.recording_facts import RecordingFacts, recording_facts
from ident.diagnosis.visibility.check import Adviser
from ident.diagnosis.visibility.visibility import EffectVisibility, JointVisibility, SmallestSize
from ident.dynamics.effects.library import library
from recordings.recording import Recording
from tests.ident import building

RECORDING = replace(building.record(noise=0.01), path=Path("a b.mcap"))
FACTS = recording_facts([building.prepared(RECORDING)])


def adviser(facts: RecordingFacts = FACTS, recording: Recording = RECORDING) -> Adviser:
    return Adviser(facts, [recording], library(), 0.03)


def visibility(name: str, *imitations: str, share: float = 0.01, outside: float = 0.9) -> EffectVisibility:
    joint = JointVisibility(0, SmallestSize(share, "a", 0.5, "N m"), outside, possible=True)
    return EffectVisibility(name, (joint,), imitations)


def facts(**changes: float) -> RecordingFacts:
    return FACTS.model_copy(update={"joints": (FACTS.joints[0].model_copy(update=changes),)})


def hidden(name: str, share: float = 0.1, outside: float = 0.9) -> EffectVisibility:
    return visibility(name, share=share, outside=outside)


def test_a_visible_effect_needs_nothing() -> None:
    advice = adviser().judged(visibility("stribeck", share=0.004))
    assert advice.why == "It shows from 0.4 % of the torque on (a = 0.5 N m, joint 1)."
    assert (advice.record, advice.command) == (None, None)


def test_effects_that_look_alike_take_a_motion_that_tells_them_apart() -> None:
    advice = adviser().judged(visibility("axis_weight", "joint_spring", "thermal_drift"))
    assert "joint_spring, thermal_drift would explain as much of 3 %" in advice.why
    assert shlex.split(advice.command or "") == [
        *("ident", "design", "--discriminate", "axis_weight", "joint_spring"),
        *("--recording", "a b.mcap", "-o", "next.toml"),
    ]


def test_no_motion_tells_an_effect_from_one_that_changes_with_time() -> None:
    advice = adviser().judged(visibility("thermal_drift", "axis_weight"))
    assert advice.command is None
    assert "at the machine" in (advice.record or "")


@pytest.mark.parametrize(
    ("name", "changes", "expected"),
    [
        ("stribeck", {"forward_share": 1.0}, "No reversal"),
        ("quadratic_friction", {"speed_spread": 0.01}, "One speed only."),
        ("load_dependent_friction", {"torque_spread": 0.05}, "The load hardly changes."),
        ("joint_spring", {"travel": 0.1}, "The joint moves over 0.1 rad only."),
        ("thermal_drift", {}, "The recording lasts 16 s only."),
    ],
)
def test_the_reason_is_what_the_motion_lacks(name: str, changes: dict[str, float], expected: str) -> None:
    advice = adviser(facts(**changes)).judged(hidden(name))
    assert advice.why.startswith(expected)
    assert advice.record


@pytest.mark.parametrize(
    ("share", "outside", "expected"),
    [
        (0.1, 0.9, "10 % of the torque (a = 0.5 N m, joint 1): less is hidden in the noise."),
        (0.1, 0.05, "other parameters of the model reproduce all but 5 % of it"),
        (3.0, 0.05, "it would have to exceed the whole torque"),
        (np.inf, 0.0, "Other parameters of the model reproduce its torque on this motion."),
    ],
)
def test_a_good_motion_hides_an_effect_in_noise_or_in_other_parameters(
    share: float, outside: float, expected: str
) -> None:
    advice = adviser().judged(hidden("stribeck", share=share, outside=outside))
    assert expected in advice.why
    assert advice.command == "ident design --with stribeck --recording 'a b.mcap' -o next.toml"


def test_drift_takes_a_longer_recording_of_a_known_trajectory() -> None:
    run = RECORDING.run.model_copy(update={"trajectory": "fig5a", "cycles": 2})
    command = adviser(recording=replace(RECORDING, run=run)).judged(hidden("thermal_drift")).command
    assert command == "daq record --traj fig5a --cycles 20"
    assert adviser().judged(hidden("thermal_drift")).command is None


@pytest.mark.parametrize(
    ("name", "torque_measured", "expected"),
    [
        ("temperature_friction", True, "temperature_1"),
        ("back_emf", True, "voltage_1"),
        ("amplifier_deadband", False, "command"),
    ],
)
def test_what_a_recording_holds_decides_what_it_can_show(name: str, torque_measured: bool, expected: str) -> None:
    recording = RECORDING if torque_measured else replace(RECORDING, effort=None)
    advice = adviser(recording=recording).unjudged(name, "Because.", untested=False)
    assert advice.why == "Because."
    assert expected in (advice.record or "")


def test_what_hardware_excludes_cannot_be_recorded() -> None:
    assert adviser().unjudged("encoder_eccentricity", "No turns.", untested=False).record is None


def test_an_effect_that_takes_both_directions_takes_a_motion_that_has_them() -> None:
    advice = adviser().unjudged("position_dependent_friction", "Joint 1 ...", untested=True)
    assert "both directions" in (advice.record or "")
    assert advice.command == "ident design --recording 'a b.mcap' -o next.toml"
