"""Recordings with different payloads are fitted together: what is known enters the model, all else is shared."""

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ident
from ident.basics.statistics import NORMAL
from ident.data.prepared_recording import prepare
from ident.dynamics import mechanisms
from ident.dynamics.motion import Motion
from ident.dynamics.torque_map import voltage_from_torque
from ident.estimation.predicted_torque import TorquePredictor
from ident.export import torque_table
from ident.export.paths import from_recording
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Axis, Rig, Torque
from tests.ident import building
from tests.ident.conftest import TRUTH
from tests.ident.identification.test_urdf_robot import URDF

PLACE = (0.2, 0.0, 0.1)
ROBOTS: dict[str, dict[str, Any]] = {
    "delta": {},
    "axes": {"mechanism": "axes", "axes": (Axis(gravity=True), Axis(gravity=True))},
    "slide": {"mechanism": "axes", "axes": (Axis(type="prismatic", gravity=True),)},
    "urdf": {"mechanism": "urdf", "urdf": URDF, "joints": ("turn", "lift", "push")},
}


def rig(kind: str, mass: float, told: bool = True) -> Rig:
    payload = {"mass": mass if told else "unknown", "com": PLACE} if mass else None
    return Rig(name=kind, payload=payload, **ROBOTS[kind])


def truth(kind: str) -> Floats:
    """Parameters of the robot without a payload."""
    count = len(mechanisms.create(rig(kind, 0)).parameters)
    return np.abs(TRUTH) if kind == "delta" else np.random.default_rng(3).uniform(0.5, 2.0, count)


def record(
    kind: str,
    mass: float,
    seed: int,
    load_friction: float = 0.0,
    told: bool = True,
    noise: Sequence[float] = (1e-3,),
) -> ident.Recording:
    """A motion of random sines with the torque of the robot and its payload, with a little noise."""
    generator, t = np.random.default_rng(seed), np.arange(0, 10, 4e-3)[:, None]
    robot = rig(kind, mass)
    omega, phase = (generator.uniform(*limits, (5, 1, robot.dof)) for limits in ((0.2, 1.5), (0, 6)))
    omega = 2 * np.pi * omega
    wave = np.exp(1j * (omega * t + phase)) * 0.12
    q, qd, qdd = (np.imag(wave * (1j * omega) ** k).sum(axis=0) for k in range(3))
    at, mechanism = Motion(q, qd, qdd, np.sign(qd)), mechanisms.create(robot)
    still = [0.0 if each.friction else 1.0 for each in mechanism.parameters]
    columns, payload = mechanism.regressor(at), mass * mechanism.torque_per_mass(at, PLACE)
    torque = columns @ truth(kind) + payload
    torque += load_friction * np.abs(columns @ (still * truth(kind)) + payload) * np.sign(qd)
    torque += np.array(noise) * torque.std(axis=0) * generator.standard_normal(torque.shape)
    return ident.Recording.from_arrays(t[:, 0], q, effort=torque, rig=rig(kind, mass, told))


@pytest.mark.parametrize("kind", ROBOTS)
def test_parameters_are_those_of_the_first_set_up(kind: str) -> None:
    model = ident.fit([record(kind, 0.0, 1), record(kind, 1.5, 2)], validate=record(kind, 3.0, 3), method="wls")
    assert model.file.payload is None
    values = np.array([float(each) for each in model.parameters.values()])
    expected = truth(kind)
    if kind == "delta":
        expected = np.append(expected, 0.0)  # its rods are points here
    np.testing.assert_allclose(values, expected, atol=0.03 * np.abs(expected).max())
    comparison = ident.compare(model, record(kind, 0.7, 4))
    assert all(joint.summary.share < 0.02 for joint in comparison.joints)


def test_friction_of_the_load_includes_that_of_the_payload() -> None:
    recordings = [record("urdf", 4.0 * k, k + 1, load_friction=0.1) for k in range(3)]
    model = ident.fit(recordings[:2], validate=recordings[2], method="wls", effects=["load_dependent_friction"])
    for joint in (1, 2, 3):
        assert float(model.parameters[f"load_dependent_friction.a{joint}"]) == pytest.approx(0.1, rel=0.1)


def test_a_first_payload_is_part_of_the_model() -> None:
    model = ident.fit([record("slide", 1.0, 1), record("slide", 2.0, 2)], method="wls")
    assert model.file.payload is not None
    assert float(model.parameters["m_1"]) == pytest.approx(truth("slide")[0] + 1.0, rel=0.02)


def amplified(gain: float, seed: int, **torque: Any) -> ident.Recording:
    """A slide whose drives report the voltage at a `gain`, with other keys of its torque map."""
    recording = record("slide", 0.0, seed)
    assert recording.effort is not None
    keys = {"gain": (gain,), "gain_source": "calibrated", "gain_uncertainty": 0.0, **torque}
    described = recording.rig.model_copy(update={"torque": Torque.model_validate(keys)})
    voltage = voltage_from_torque(recording.effort, described.torque)
    return replace(recording, path=Path(f"gain{gain:g}.mcap"), voltage=voltage, effort=None, rig=described)


def test_recordings_with_different_known_gains_share_all_parameters() -> None:
    recordings = [amplified(0.5, 1, gain_uncertainty=0.01), amplified(3.0, 2, gain_uncertainty=0.04)]
    other = amplified(7.0, 4)
    models = [ident.fit(some, validate=other, method="wls") for some in (recordings, recordings[:1], recordings[1:])]
    values = [[*map(float, model.parameters.values())] for model in models]
    np.testing.assert_allclose(values, [truth("slide")] * 3, rtol=0.02)
    assert [model.file.assessment.gain_uncertainty for model in models] == [0.04, 0.01, 0.04]  # type: ignore[union-attr]
    assert all(joint.summary.share < 0.02 for joint in ident.compare(models[0], other).joints)
    assert not ident.diagnose(recordings, validate=other).findings
    table = torque_table.tables(models[0], from_recording(other, models[0].file), torque_table.TorqueSummary())
    computed = np.concatenate([chunk["voltage_1"] for chunk in table])
    assert np.nanstd(computed - other.voltage[: len(computed), 0]) < 0.1 * other.voltage.std()


def test_effects_of_the_amplifier_are_computed_by_the_gain_of_the_recording() -> None:
    structure = building.structure(amplified(0.5, 1), "encoder_eccentricity", "amplifier_deadband")
    predictor = TorquePredictor(building.prepared(amplified(3.0, 2)))
    assert predictor.effect_inputs(structure, building.start(structure)).rig.torque.gain == (3.0,)


def test_gains_that_differ_have_to_be_known() -> None:
    known, *assumed = amplified(0.5, 1), *(amplified(gain, 2, gain_source="assumed") for gain in (0.5, 3.0))
    for pair in ([known, assumed[0]], assumed[::-1], [assumed[0], known]):
        with pytest.raises(BadInput, match="fit them separately, or calibrate gains that are only assumed"):
            ident.fit(pair, method="wls")
    with pytest.raises(BadInput, match=r"torque.gain is \(0.5,\) in the model, \(3.0,\) .*, or calibrate gains"):
        ident.compare(ident.fit(known, method="wls"), assumed[1])


def test_another_robot_stays_another_robot() -> None:
    with pytest.raises(BadInput, match="recordings of the same rig expected"):
        ident.fit([record("slide", 1.0, 1), record("axes", 1.0, 2)], method="wls")


@pytest.mark.parametrize("kind", ROBOTS)
def test_an_unknown_payload_is_a_parameter(kind: str, tmp_path: Path) -> None:
    recordings = [record(kind, mass, seed, told=mass != 2.2) for seed, mass in enumerate((2.2, 0.0, 1.5), start=1)]
    model = ident.fit(recordings, validate=record(kind, 2.2, 4, told=False), method="wls")
    model.save(tmp_path / "model.json")
    mass = ident.load_model(tmp_path / "model.json").parameters["unknown_payload.m"]
    assert mass.ci95 is not None
    low, high = mass.ci95
    assert low - 0.01 < 2.2 < high + 0.01
    assert high - low < 0.3
    comparison = ident.compare(model, record(kind, 2.2, 5, told=False))
    assert all(joint.summary.share < 0.02 for joint in comparison.joints)


@pytest.mark.parametrize(("kind", "known"), [("axes", "xz"), ("urdf", "xyz")])
def test_the_place_of_an_unknown_payload_is_found_too(kind: str, known: str, tmp_path: Path) -> None:
    empty, loaded, other = record(kind, 0.0, 1), record(kind, 2.2, 2), record(kind, 2.2, 3)
    unknown = Rig.model_validate({**rig(kind, 0.0).model_dump(), "payload": "unknown"})
    model = ident.fit([empty, replace(loaded, rig=unknown)], validate=replace(other, rig=unknown), method="wls")
    model.save(tmp_path / "model.json")
    parameters = ident.load_model(tmp_path / "model.json").parameters
    for name, true in {"m": 2.2, **{axis: PLACE["xyz".index(axis)] for axis in known}}.items():
        low, high = parameters[f"unknown_payload.{name}"].ci95 or (np.nan, np.nan)
        assert low - 0.01 < true < high + 0.01
        assert high - low < 0.1
    assert all(joint.summary.share < 0.02 for joint in ident.compare(model, replace(other, rig=unknown)).joints)


def test_errors_of_an_unknown_payload_are_as_large_as_its_intervals_say() -> None:
    noise, scores = (1e-3, 5e-2, 1e-3), list[float]()
    for seed in (1, 3):
        empty, loaded = (record("urdf", mass, seed + (mass > 0), noise=noise) for mass in (0.0, 2.2))
        unknown = Rig.model_validate({**rig("urdf", 0.0).model_dump(), "payload": "unknown"})
        parameters = ident.fit([empty, replace(loaded, rig=unknown)], method="wls").parameters
        for name, true in zip("mxyz", (2.2, *PLACE), strict=True):
            low, high = parameters[f"unknown_payload.{name}"].ci95 or (np.nan, np.nan)
            scores.append((float(parameters[f"unknown_payload.{name}"]) - true) / (high - low) * 2 * NORMAL)
    assert 0.4 < np.sqrt(np.mean(np.square(scores))) < 1.6


def test_an_unknown_payload_needs_another_set_up_and_is_fitted_before_a_diagnosis() -> None:
    unknown, empty = record("slide", 2.0, 1, told=False), record("slide", 0.0, 2)
    with pytest.raises(BadInput, match=r'only payload\.mass = "unknown" found'):
        ident.fit([unknown], method="wls")
    with pytest.raises(BadInput, match="payload of known mass expected"):
        ident.diagnose([unknown], validate=empty)
    with pytest.raises(BadInput, match="payload of known mass expected"):
        ident.compare(ident.fit([empty], method="wls"), unknown)


def test_a_model_is_judged_on_all_recordings_that_are_held_out() -> None:
    train, others = record("slide", 0.0, 1), [record("slide", mass, 2, noise=(0.01 * mass,)) for mass in (1.0, 2.0)]
    alone = [ident.fit(train, validate=each, method="wls").file.validate_ for each in others]
    both = ident.fit(train, validate=others, method="wls").file.validate_
    assert both is not None
    assert [each.name for each in both.recordings] == [each.recordings[0].name for each in alone if each]
    squares = [each.fitted.rms[0] ** 2 for each in alone if each]
    assert both.fitted.rms[0] ** 2 == pytest.approx(np.mean(squares), rel=0.02)


@pytest.mark.parametrize("kind", list(ROBOTS))
@pytest.mark.parametrize("told", [True, False], ids=["known", "found"])
def test_arms_behind_springs_and_gaps_carry_the_payload(kind: str, told: bool) -> None:
    """Its inertia turns with the arm: as a torque along the motors' motion, a spring seemed too soft."""
    place = (math.nan,) * 3 if kind == "urdf" and not told else PLACE
    empty, loaded = (prepare(record(kind, mass, seed=1), "parallel", 20.0) for mass in (0.0, 2.0))
    inputs = TorquePredictor(empty).effect_inputs(empty.base_structure, truth(kind))
    of_mass = mechanisms.torque_of_masses(loaded.mechanism, [(2.0, PLACE)], inputs.motion)
    carrying = replace(
        inputs,
        beyond=((2.0 if told else math.nan, place),),
        unknown_payload=() if told else ((2.0, PLACE if kind == "urdf" else ()),),
        arm_load_at=None if told else lambda inputs: of_mass,
    ).flexible_joints(0.0)
    bare = inputs.flexible_joints(0.0)
    change = carrying.rigid_torque(inputs.motion) - bare.rigid_torque(inputs.motion)
    known = np.isfinite(change).all(axis=1)
    np.testing.assert_allclose(change[known], of_mass[known], atol=1e-9 * np.abs(of_mass[known]).max())
    assert not np.abs(np.nan_to_num(carrying.load if carrying.load is not None else 0.0)).max() > 1e-9
    assert (np.abs(carrying.constants - bare.constants) > 0).any()
