"""`ident check`: reasons why recordings do not show an effect, what to record, and the document."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ident
from ident.data.recording_facts import RecordingFacts, recording_facts
from ident.diagnosis.visibility.check import Adviser, check
from ident.diagnosis.visibility.visibility import EffectVisibility, JointVisibility, SmallestSize
from ident.dynamics.effects.library import library
from recordings.recording import Recording
from tests.foreign.pairs import TRAIN, VALIDATE, Setting, make
from tests.ident import building

RECORDING = replace(building.record(noise=0.01), path=Path("a b.mcap"))
FACTS = recording_facts([building.prepared(RECORDING)])


def adviser(facts: RecordingFacts = FACTS, recording: Recording = RECORDING) -> Adviser:
    return Adviser(facts, [recording], library(), 0.03)


def visibility(name: str, *imitations: str, share: float = 0.1, outside: float = 0.9) -> EffectVisibility:
    joint = JointVisibility(0, SmallestSize(share, "a", 0.5, "N m"), outside, possible=True)
    return EffectVisibility(name, (joint,), imitations)


DISCRIMINATE = "ident design --discriminate axis_weight joint_spring --recording 'a b.mcap' -o next.toml"
WITH_STRIBECK = "ident design --with stribeck --recording 'a b.mcap' -o next.toml"


@pytest.mark.parametrize(
    ("seen", "why", "command"),
    [
        (visibility("stribeck", share=0.004), "It shows from 0.4 % of the torque on (a = 0.5 N m, joint 1).", None),
        (
            visibility("axis_weight", "joint_spring", "thermal_drift", share=0.01),
            "joint_spring, thermal_drift would explain as much of 3 %",
            DISCRIMINATE,
        ),
        (visibility("thermal_drift", "axis_weight", share=0.01), "axis_weight would explain as much", None),
        (
            visibility("stribeck"),
            "10 % of the torque (a = 0.5 N m, joint 1): less is hidden in the noise.",
            WITH_STRIBECK,
        ),
        (
            visibility("stribeck", outside=0.05),
            "other parameters of the model reproduce all but 5 % of it",
            WITH_STRIBECK,
        ),
        (visibility("stribeck", share=3.0, outside=0.05), "it would have to exceed the whole torque", WITH_STRIBECK),
        (
            visibility("stribeck", share=np.inf, outside=0.0),
            "Other parameters of the model reproduce its torque on this motion.",
            WITH_STRIBECK,
        ),
        (visibility("thermal_drift"), "The recording lasts 16 s only.", None),
    ],
)
def test_what_is_hidden_is_explained_with_the_motion_that_would_show_it(
    seen: EffectVisibility, why: str, command: str | None
) -> None:
    advice = adviser().judged(seen)
    assert why in advice.why
    assert advice.command == command
    assert bool(advice.record) == ("shows from" not in why)


@pytest.mark.parametrize(
    ("name", "changes", "expected"),
    [
        ("stribeck", {"forward_share": 1.0}, "No reversal"),
        ("quadratic_friction", {"speed_spread": 0.01}, "One speed only."),
        ("load_dependent_friction", {"torque_spread": 0.05}, "The load hardly changes."),
        ("joint_spring", {"travel": 0.1}, "The joint moves over 0.1 rad only."),
    ],
)
def test_the_reason_is_what_the_motion_lacks(name: str, changes: dict[str, float], expected: str) -> None:
    joints = (FACTS.joints[0].model_copy(update=changes),)
    advice = adviser(FACTS.model_copy(update={"joints": joints})).judged(visibility(name))
    assert advice.why.startswith(expected)
    assert advice.record


def test_drift_takes_a_longer_recording_of_a_known_trajectory() -> None:
    run = RECORDING.run.model_copy(update={"trajectory": "fig5a", "cycles": 2})
    command = adviser(recording=replace(RECORDING, run=run)).judged(visibility("thermal_drift")).command
    assert command == "daq record --traj fig5a --cycles 20"


@pytest.mark.parametrize(
    ("name", "torque_measured", "untested", "record", "command"),
    [
        ("temperature_friction", True, False, "temperature_1", None),
        ("back_emf", True, False, "voltage_1", None),
        ("amplifier_deadband", False, False, "command", None),
        ("encoder_eccentricity", True, False, "", None),  # hardware excludes it
        (
            "position_dependent_friction",
            True,
            True,
            "both directions",
            "ident design --recording 'a b.mcap'",
        ),
    ],
)
def test_what_a_recording_holds_decides_what_it_can_show(
    name: str, torque_measured: bool, untested: bool, record: str, command: str | None
) -> None:
    recording = RECORDING if torque_measured else replace(RECORDING, effort=None)
    advice = adviser(recording=recording).unjudged(name, "Because.", untested)
    assert advice.why == "Because."
    assert record in (advice.record or "")
    assert bool(record) == bool(advice.record)
    assert command is None or str(advice.command).startswith(command)


SLOW = ("backlash", "joint_elasticity", "encoder_eccentricity")
"""Effects that take seconds to screen."""
LIBRARY = {name: effect for name, effect in library().items() if name not in SLOW}
STATUSES = ("visible", "confusable", "not-visible")


def test_every_effect_is_judged_once_the_visible_first(write: Callable[[Recording], Path], tmp_path: Path) -> None:
    path = write(replace(building.record(2, noise=0.05, encoder_step=1e-5), path=tmp_path / "bench.mcap"))
    document = check([path], LIBRARY, 0.03)
    expected = {name for name, effect in LIBRARY.items() if "axes" in effect.mechanisms and not effect.mandatory}
    statuses = {entry.effect: entry.status for entry in document.effects}
    assert (statuses.keys(), len(document.effects)) == (expected, len(expected))
    assert sorted(statuses.values(), key=STATUSES.index) == list(statuses.values())
    for entry in document.effects:
        assert entry.why
        shows = entry.status != "not-visible"
        assert not shows or (entry.joints and entry.smallest and entry.smallest.share <= document.share)
        assert bool(entry.confusable_with) == (entry.status == "confusable")
    assert statuses["quadratic_friction"] == "visible"
    for name in ("back_emf", "amplifier_deadband", "temperature_friction"):
        assert statuses[name] == "not-visible"
    (recording,) = document.recordings
    assert (recording.rate_hz, recording.cycles, recording.simulated) == (building.RATE, 4, True)
    assert [joint.encoder_step for joint in document.joints] == pytest.approx([1e-5, 1e-5])
    assert all(joint.noise_rms for joint in document.joints)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "noise", "visible"), [("stribeck", 0.01, True), ("asymmetric_viscous", 0.8, False)])
def test_a_diagnosis_of_a_foreign_plant_finds_what_is_visible(
    name: str, noise: float, visible: bool, tmp_path: Path
) -> None:
    (truth,) = make(tmp_path, [name], [0.01], 5, Setting(volts=noise))["effects"]
    files = [tmp_path / TRAIN, tmp_path / VALIDATE]
    (entry,) = (entry for entry in check(files, LIBRARY, 0.03).effects if entry.effect == name)
    assert entry.smallest
    assert (abs(truth["parameters"]["a"]) > entry.smallest.value) == visible
    findings = ident.diagnose(files[:1], validate=files[1:]).findings
    assert (name in {finding.effect for finding in findings}) == visible
