"""Torque of a model for a given motion."""

from collections.abc import Callable

import numpy as np
import pytest

from ident.data.prepared_recording import PreparedRecording, prepare
from ident.dynamics.effects.library import library
from ident.dynamics.inverse_dynamics import InverseDynamics
from ident.dynamics.motion import Motion
from ident.dynamics.structure import ModelStructure, Term
from ident.estimation.predicted_torque import TorquePredictor
from recordings.errors import BadInput
from recordings.recording import Floats, Recording

EFFECTS = {
    "none": (),
    "of the whole robot": ("rod_inertia", "air_drag"),
    "on some joints": ("stribeck", "joint_spring"),
    "with a memory": ("presliding_hysteresis",),
    "of time": ("thermal_drift", "payload_change"),
    "between torque and voltage": ("torque_gain_mismatch", "back_emf"),
    "on the rig": ("geometry_error",),
}


@pytest.fixture(scope="module")
def prepared(make: Callable[..., Recording]) -> PreparedRecording:
    return prepare(make(cycles=1), "parallel", 20.0)


def structure_with(
    prepared: PreparedRecording, names: tuple[str, ...], truth: Floats
) -> tuple[ModelStructure, Floats]:
    """The mechanism with the effects `names`, on joints 1 and 3 where they may be, and parameters for all."""
    as_recorded = prepared.as_recorded
    structure = ModelStructure(as_recorded.mechanism, as_recorded.rig)
    for name in names:
        effect = library()[name]
        structure = structure.with_term(Term(name, effect, (0, 1, 2) if effect.whole_robot else (0, 2)))
    added = [0.01 if entry.linear else entry.scale for entry in structure.parameters[len(truth) :]]
    return structure, np.concatenate([truth, added])


@pytest.mark.parametrize("names", EFFECTS.values(), ids=EFFECTS)
def test_torque_is_that_which_is_predicted_for_a_recording_and_the_sum_of_its_terms(
    prepared: PreparedRecording, names: tuple[str, ...], truth: Floats
) -> None:
    structure, x = structure_with(prepared, names, truth)
    dynamics, predictor = InverseDynamics(structure, x), TorquePredictor(prepared)
    motion = prepared.as_recorded.motion
    inputs = dynamics.inputs(motion, dt=1 / prepared.samples.rate, t=prepared.instant_time)
    expected = predictor.unfiltered(structure, x)
    known = np.isfinite(expected)
    assert known.mean() > 0.9
    scale = np.abs(expected[known]).max()
    np.testing.assert_allclose(dynamics.reported(inputs)[known], expected[known], atol=1e-9 * scale)
    terms = dynamics.terms_with_corrections(lambda model: predictor.effect_inputs(structure, model.values))
    assert set(terms) == {"inertia", "inertia_coupling", "coriolis", "gravity", "viscous", "coulomb", *names}
    torque = dynamics.torque(predictor.effect_inputs(structure, x))
    known &= np.isfinite(torque)
    np.testing.assert_allclose(sum(terms.values())[known], torque[known], atol=1e-12 * scale)
    nothing = (*EFFECTS["between torque and voltage"], "payload_change")  # which is there after the run here
    for name in names:
        assert (np.abs(terms[name][known]).max() > 1e-6) == (name not in nothing)


@pytest.mark.parametrize("name", ["backlash", "joint_elasticity"])
def test_effects_on_the_arms_load_what_is_between_motor_and_arm(
    prepared: PreparedRecording, truth: Floats, name: str
) -> None:
    """Arms that are heavier by an effect are transmitted like arms whose parameter T_g says so."""
    base, everywhere = prepared.base_structure, (0, 1, 2)
    between = Term(name, library()[name], everywhere)
    heavier = Term("arm_mass_mismatch", library()["arm_mass_mismatch"], everywhere)
    size, beyond = (5e-4 if name == "backlash" else 1e-3), 0.7
    values = np.array([*[size] * 3, 0.3, *([0.05] if name == "joint_elasticity" else [])])
    by_parameter = truth.copy()
    by_parameter[[entry.name for entry in base.parameters].index("T_g")] += beyond
    inputs = {"dt": 1 / prepared.samples.rate, "t": prepared.instant_time}
    computed, predicted = [], []
    for structure, x in (
        (base.with_term(between), np.r_[by_parameter, values]),
        (base.with_term(heavier).with_term(between), np.r_[truth, [beyond] * 3, values]),
    ):
        dynamics = InverseDynamics(structure, x)
        computed.append(dynamics.terms(dynamics.inputs(prepared.as_recorded.motion, **inputs))[name])
        predicted.append(TorquePredictor(prepared).unfiltered(structure, x))
    known = np.isfinite(predicted[0]).all(axis=1)
    added = np.sqrt(np.mean(computed[0][known] ** 2))
    for of_parameter, of_effect in (computed, predicted):
        error = np.sqrt(np.mean((of_effect - of_parameter)[known] ** 2))
        assert 0 < error < 0.02 * added  # the load is that at the motors' angles, which hardly differ from the arms'


@pytest.mark.parametrize(
    ("name", "given", "needed"),
    [
        ("joint_elasticity", {"t": 1}, "dt"),
        ("thermal_drift", {"dt": 1}, "t, the time"),
        ("actuation_delay", {}, "dt"),
        ("temperature_friction", {"dt": 1, "t": 1}, "temperature"),
    ],
)
def test_what_an_effect_needs_and_is_not_given_is_refused_by_name(
    prepared: PreparedRecording, truth: Floats, name: str, given: dict[str, int], needed: str
) -> None:
    structure, x = structure_with(prepared, (name,), truth)
    dynamics = InverseDynamics(structure, x)
    values = {"dt": 1 / prepared.samples.rate, "t": prepared.instant_time}
    inputs = dynamics.inputs(prepared.as_recorded.motion, **{key: values[key] for key in given})
    with pytest.raises(BadInput, match=f"effect {name} needs {needed}"):
        dynamics.reported(inputs)


def test_an_encoder_error_corrects_velocity_and_acceleration_with_the_position(
    prepared: PreparedRecording, truth: Floats
) -> None:
    structure, x = structure_with(prepared, ("encoder_eccentricity",), truth)
    x = np.where(structure.linear, x, 0.02)
    x[[entry.name.endswith(".N") for entry in structure.parameters]] = 3.0
    time = np.arange(4000) / 2000
    q = np.stack([0.3 * np.sin(4 * time + shift) for shift in (0.0, 1.0, 2.0)], axis=1)
    qd = np.stack([1.2 * np.cos(4 * time + shift) for shift in (0.0, 1.0, 2.0)], axis=1)
    motion = InverseDynamics(structure, x).inputs(Motion(q, qd, -16 * q, np.sign(qd))).motion
    inner = slice(5, -5)
    velocity = np.gradient(motion.position, time, axis=0)
    np.testing.assert_allclose(motion.velocity[inner], velocity[inner], atol=1e-4)
    np.testing.assert_allclose(motion.acceleration[inner], np.gradient(velocity, time, axis=0)[inner], atol=1e-3)
    assert np.abs(motion.velocity - qd).max() > 0.01


def test_elasticity_belongs_to_the_torque_and_a_delay_to_the_voltage(
    prepared: PreparedRecording, truth: Floats
) -> None:
    inputs_of = {"dt": 1 / prepared.samples.rate, "t": prepared.instant_time}
    for name, of_torque in (("joint_elasticity", True), ("backlash", True), ("actuation_delay", False)):
        structure, x = structure_with(prepared, (name,), truth)
        dynamics = InverseDynamics(structure, x)
        inputs = dynamics.inputs(prepared.as_recorded.motion, **inputs_of)
        term = dynamics.terms(inputs)[name]
        changed = dynamics.reported(inputs) - dynamics.torque(inputs)
        assert (np.nanmax(np.abs(term)) > 1e-3) == of_torque
        assert (np.nanmax(np.abs(changed)) > 1e-3) != of_torque
