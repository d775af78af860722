"""The document of `ident check`."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

import ident
from ident.diagnosis.visibility.check import check
from ident.diagnosis.visibility.visibility_document import CheckDocument
from ident.dynamics.effects.library import library
from recordings.recording import Recording
from tests.foreign.pairs import TRAIN, VALIDATE, Setting, make
from tests.ident import building

SLOW = ("backlash", "joint_elasticity", "encoder_eccentricity")
"""Effects that take seconds to screen."""
LIBRARY = {name: effect for name, effect in library().items() if name not in SLOW}
STATUSES = ("visible", "confusable", "not-visible")


@pytest.fixture(scope="module")
def document(write: Callable[[Recording], Path], tmp_path_factory: pytest.TempPathFactory) -> CheckDocument:
    path = tmp_path_factory.mktemp("check") / "bench.mcap"
    write(replace(building.record(2, noise=0.05, encoder_step=1e-5), path=path))
    return check([path], LIBRARY, 0.03)


def test_every_effect_of_the_mechanism_is_judged_once(document: CheckDocument) -> None:
    expected = {name for name, effect in LIBRARY.items() if "axes" in effect.mechanisms and not effect.mandatory}
    assert sorted(entry.effect for entry in document.effects) == sorted(expected)


def test_visible_effects_come_first_each_with_its_size(document: CheckDocument) -> None:
    ranks = [STATUSES.index(entry.status) for entry in document.effects]
    assert ranks == sorted(ranks)
    for entry in document.effects:
        assert entry.why
        if entry.status != "not-visible":
            assert entry.smallest
            assert entry.smallest.share <= document.share
            assert entry.joints
        assert bool(entry.confusable_with) == (entry.status == "confusable")


def test_a_torque_recording_shows_no_amplifier(document: CheckDocument) -> None:
    statuses = {entry.effect: entry.status for entry in document.effects}
    assert statuses["quadratic_friction"] == "visible"
    for name in ("back_emf", "amplifier_deadband", "temperature_friction"):
        assert statuses[name] == "not-visible"


def test_sampling_and_joints_are_stated(document: CheckDocument) -> None:
    (recording,) = document.recordings
    assert (recording.rate_hz, recording.cycles, recording.simulated) == (building.RATE, 4, True)
    assert [joint.encoder_step for joint in document.joints] == pytest.approx([1e-5, 1e-5])
    assert all(joint.noise_rms for joint in document.joints)
    assert document.as_json()["schema"] == 2


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
