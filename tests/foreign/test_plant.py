"""Each effect of the second plant against its definition, in the reported signals."""

from collections.abc import Callable

import numpy as np
import pytest

from drivers.simulated.config import EffectSpec
from drivers.simulated.effect import HiddenEffect, build, library
from recordings.recording import Floats
from tests.drivers.simulated.exact_delta import exact_torque
from tests.foreign.plant import KINDS, Plant, Reported, name

SLIDING = 0.3
"""Above this speed no sample is averaged over a reversal [rad/s]."""


def hidden(effect: str, joints: tuple[int, ...] = (1, 2, 3), **parameters: float) -> HiddenEffect:
    if effect in KINDS:
        return KINDS[effect].model_validate({"joints": joints, **parameters})
    return build(EffectSpec(name=effect, joints=joints, parameters=parameters))


def torque(plant: Plant, reported: Reported) -> Floats:
    """(m, 3) torque of the reported voltages by the torque map of the rig."""
    signed_torque: Floats = np.array(plant.robot.rig.torque.gain) * reported.voltage * np.abs(reported.voltage)
    return signed_torque


def at_samples(plant: Plant, values: Floats) -> Floats:
    """Rows of `values`, which follow the reference motion, at the reported samples."""
    sampled: Floats = values[plant.reference.rows[:: plant.reference.per_sample]]
    return sampled


def added_torque(plant: Plant, effect: HiddenEffect) -> tuple[Reported, Floats]:
    """Signals without the effect, and the torque that the effect adds (m, 3); NaN where a joint hardly moves."""
    unaffected = plant.report()
    difference = torque(plant, plant.report([effect])) - torque(plant, unaffected)
    return unaffected, np.where(np.abs(unaffected.velocity) > SLIDING, difference, np.nan)


def assert_close(actual: Floats, expected: Floats, tolerance: float = 2e-3) -> None:
    scale = np.nanmax(np.abs(actual))
    known = np.isfinite(actual)
    assert known.mean() > 0.5
    np.testing.assert_allclose(actual[known], np.broadcast_to(expected, actual.shape)[known], atol=tolerance * scale)


def test_torque_without_effects_is_rigid_body_torque_and_friction(plant: Plant) -> None:
    reference, robot = plant.reference, plant.robot
    rigid = exact_torque(robot.rig.geometry, robot.links, reference.theta, reference.rate, reference.acceleration)
    friction = robot.friction.viscous * reference.rate + np.array(robot.friction.coulomb) * np.sign(reference.rate)
    moving = (np.abs(at_samples(plant, reference.rate)) > SLIDING).all(axis=1)
    reported_torque = torque(plant, plant.report())
    np.testing.assert_allclose(
        reported_torque[moving],
        at_samples(plant, rigid + friction)[moving],
        atol=2e-3 * np.abs(reported_torque).max(),
    )


FORMULAS: dict[str, tuple[dict[str, float], Callable[[Reported], Floats | float]]] = {
    "cogging": ({"a": 0.4, "N": 24, "phase": 0.5}, lambda r: 0.4 * np.sin(24 * r.position + 0.5)),
    "uneven_grease": ({"a": 0.3, "phase": 1.0}, lambda r: 0.3 * np.sin(2 * r.position + 1) * r.velocity),
    "bearing_load": ({"a": 0.05}, lambda r: 0.05 * np.abs(r.acceleration) * np.sign(r.velocity)),
    "fan": ({"a": 0.5, "f": 7.0, "phase": 0.2}, lambda r: 0.5 * np.sin(2 * np.pi * 7 * time(r) + 0.2)),
    "creeping_zero": ({"a": 0.5, "T": 4.0}, lambda r: 0.5 * (1 - np.exp(-time(r) / 4))),
    "eddy_brake": ({"b": 0.4, "v": 0.8}, lambda r: 0.4 * r.velocity / (1 + (r.velocity / 0.8) ** 2)),
    "sigmoid": ({"a": 0.5, "v": 0.7}, lambda r: 0.5 * np.tanh(r.velocity / 0.7)),
    "far_damper": ({"c": 2.0, "q_0": -0.2}, lambda r: 2 * np.maximum(r.position + 0.2, 0) * r.velocity),
    "mutual_inertia": ({"J": 0.1}, lambda r: 0.1 * r.acceleration[:, [2, 1, 0]]),
    "friction_of_other": (
        {"a": 0.5, "phase": 0.4, "ahead": 2.7},
        lambda r: 0.5 * np.sin(2 * r.position[:, [2, 0, 1]] + 0.4) * np.sign(r.velocity),
    ),
    "shaking_by_other": (
        {"a": 0.5, "N": 9.0, "phase": 0.4, "ahead": 1.2},
        lambda r: 0.5 * np.sin(9 * r.position[:, [1, 2, 0]] + 0.4),
    ),
    "tangled_cables": ({"k": 1.5}, lambda r: r.position @ np.array([[1.5, 0, -1.5], [0, 0, 0], [-1.5, 0, 1.5]])),
    "spring_and_damper": (
        {"k": 2.0, "T": 0.2},
        lambda r: (r.position + 0.2 * r.velocity) @ np.array([[2, 0, -2], [0, 2, 0], [-2, 0, 2]]),
    ),
}
"""Those of this plant alone, and one more: tests/drivers/simulated compares the laws of both plants."""


def time(reported: Reported) -> Floats:
    return np.arange(len(reported.position))[:, None] / 500.0


@pytest.mark.parametrize("effect", FORMULAS)
def test_additive_effect_adds_its_formula_on_its_joints(plant: Plant, effect: str) -> None:
    parameters, formula = FORMULAS[effect]
    unaffected, difference = added_torque(plant, hidden(effect, (1, 3), **parameters))
    assert_close(difference[:, [0, 2]], np.broadcast_to(formula(unaffected), difference.shape)[:, [0, 2]])
    assert not np.nan_to_num(difference[:, 1]).any()


def test_air_drag_takes_power_from_the_platform(plant: Plant) -> None:
    reference = plant.reference
    unaffected, difference = added_torque(plant, hidden("air_drag", c=3.0))
    power = (np.nan_to_num(difference) * unaffected.velocity).sum(axis=1)
    speed = np.linalg.norm(at_samples(plant, reference.platform_rate), axis=1)
    known = np.isfinite(difference).all(axis=1)
    np.testing.assert_allclose(power[known], 3.0 * speed[known] ** 3, atol=0.02 * power.max())


def test_actuation_delay_shifts_the_voltage(plant: Plant) -> None:
    unaffected, delayed = plant.report(), plant.report([hidden("actuation_delay", delay=0.004)])
    np.testing.assert_allclose(delayed.voltage[:-2], unaffected.voltage[2:], atol=1e-9)


def test_amplifier_effects_change_the_voltage(plant: Plant) -> None:
    unaffected = plant.report()
    volts, gain = unaffected.voltage, np.array(plant.robot.rig.torque.gain)
    with_gain = plant.report([hidden("torque_gain_mismatch", (2,), mismatch=0.1)]).voltage
    np.testing.assert_allclose(with_gain[:, 1] ** 2 * 1.1, volts[:, 1] ** 2, rtol=1e-9)
    np.testing.assert_array_equal(with_gain[:, 0], volts[:, 0])
    with_exponent = plant.report([hidden("torque_map_exponent", excess=0.2)]).voltage
    np.testing.assert_allclose(gain * np.abs(with_exponent) ** 2.2, gain * volts**2, rtol=1e-9)
    with_back_emf = plant.report([hidden("back_emf", k_e=0.1)]).voltage
    np.testing.assert_allclose(with_back_emf - volts, 0.1 * unaffected.velocity, atol=2e-4)
    with_deadband = plant.report([hidden("amplifier_deadband", width=0.2)]).voltage
    np.testing.assert_allclose(with_deadband - volts, 0.2 * np.sign(volts), atol=1e-9)
    level = 1.2 * np.abs(volts).max()
    commanded = plant.report([hidden("amplifier_saturation", inverse_level=1 / level, n=5.0)]).voltage
    np.testing.assert_allclose(commanded / (1 + np.abs(commanded / level) ** 5) ** 0.2, volts, rtol=1e-9)


def test_encoder_effects_change_the_reported_position(plant: Plant) -> None:
    unaffected = plant.report()
    shifted = plant.report([hidden("encoder_zero_offset", (1,), c=0.02)])
    np.testing.assert_allclose(
        shifted.position - unaffected.position, np.broadcast_to([0.02, 0, 0], unaffected.position.shape)
    )
    np.testing.assert_allclose(shifted.voltage, unaffected.voltage)
    eccentric = plant.report([hidden("encoder_eccentricity", a=1e-3, N=21, phase=0.4)])
    np.testing.assert_allclose(
        eccentric.position - unaffected.position, 1e-3 * np.sin(21 * unaffected.position + 0.4), atol=1e-12
    )


def test_ball_friction_takes_power_wherever_the_robot_moves(plant: Plant) -> None:
    unaffected, difference = added_torque(plant, hidden("passive_joint_friction", mu=0.5, viscous=0.1))
    power = (difference * unaffected.velocity).sum(axis=1)
    assert (power[np.isfinite(power)] > 0).all()


def test_self_heating_lowers_friction_the_more_the_longer_it_runs(plant: Plant) -> None:
    _, difference = added_torque(plant, hidden("self_heating", fall=0.3, T=3.0))
    friction = plant.robot.friction
    velocity = plant.report().velocity
    share = difference / (friction.viscous * velocity + np.array(friction.coulomb) * np.sign(velocity))
    early, late = (np.nanmean(share[rows]) for rows in (slice(0, 500), slice(-3000, None)))
    assert -0.1 < early < 0
    assert late == pytest.approx(-0.3, abs=0.06)


def test_joint_elasticity_deflects_by_the_torque_and_accelerates_the_motor(plant: Plant) -> None:
    compliance = 1e-3
    unaffected, elastic = plant.report(), plant.report([hidden("joint_elasticity", compliance=compliance)])
    reference, robot = plant.reference, plant.robot
    links = robot.links.model_copy(update={"motor_inertia": 0.0})
    load = exact_torque(robot.rig.geometry, links, reference.theta, reference.rate, reference.acceleration)
    twist = compliance * at_samples(plant, load)
    np.testing.assert_allclose(elastic.position - unaffected.position, twist, atol=1e-9)
    acceleration_torque = robot.links.motor_inertia * (elastic.acceleration - unaffected.acceleration)
    acceleration_torque += robot.friction.viscous * (elastic.velocity - unaffected.velocity)
    moving = (np.abs(unaffected.velocity) > SLIDING).all(axis=1)
    change = torque(plant, elastic) - torque(plant, unaffected)
    np.testing.assert_allclose(
        change[moving], acceleration_torque[moving], atol=0.02 * np.abs(acceleration_torque).max()
    )


def test_backlash_is_visible_only_where_the_load_changes_sign(plant: Plant, light: Plant) -> None:
    half_gap = 1e-3
    change_under_load, change_with_reversals = (
        torque(machine, machine.report([hidden("backlash", b=half_gap)])) - torque(machine, machine.report())
        for machine in (plant, light)
    )
    scale = [np.abs(torque(machine, machine.report())).max() for machine in (plant, light)]
    assert np.abs(change_under_load).max() < 0.01 * scale[0]
    assert np.abs(change_with_reversals).max() > 0.05 * scale[1]


@pytest.mark.parametrize("effect", [*library(), *KINDS])
def test_every_effect_has_its_name_and_is_visible_on_its_joints(light: Plant, effect: str) -> None:
    kind = type(build(EffectSpec(name=effect))) if effect in library() else KINDS[effect]
    built = kind(joints=(1, 2)) if kind.between_joints else kind()
    assert name(built) == effect
    unaffected, changed = light.report(), light.report([built])
    assert np.isfinite(changed.voltage).all()
    difference = np.abs(changed.voltage - unaffected.voltage) + np.abs(changed.position - unaffected.position)
    assert (difference.max(axis=0) > 1e-5)[[joint - 1 for joint in built.joints]].all()
