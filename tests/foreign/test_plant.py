"""Each effect of the second plant against its definition, in the reported signals."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from drivers.simulated.config import EffectSpec
from drivers.simulated.effect import HiddenEffect, build, library
from recordings.recording import Floats
from tests.drivers.simulated.exact_delta import exact_torque
from tests.foreign import out_of_library
from tests.foreign.plant import Plant, Reported, name

SLIDING = 0.3
"""Above this speed no sample is averaged over a reversal [rad/s]."""


def hidden(effect: str, joints: tuple[int, ...] = (1, 2, 3), **parameters: float) -> HiddenEffect:
    if effect in out_of_library.KINDS:
        return out_of_library.KINDS[effect].model_validate({"joints": joints, **parameters})
    return build(EffectSpec(name=effect, joints=joints, parameters=parameters))


def torque(plant: Plant, reported: Reported) -> Floats:
    """(m, 3) torque of the reported voltages by the torque map of the rig."""
    signed_torque: Floats = np.array(plant.robot.rig.torque.gain) * reported.voltage * np.abs(reported.voltage)
    return signed_torque


def added_torque(plant: Plant, effect: HiddenEffect) -> tuple[Reported, Floats]:
    """Signals without the effect, and the torque that the effect adds (m, 3); NaN where a joint hardly moves."""
    bare = plant.report()
    difference = torque(plant, plant.report([effect])) - torque(plant, bare)
    return bare, np.where(np.abs(bare.velocity) > SLIDING, difference, np.nan)


def assert_close(actual: Floats, expected: Floats, tolerance: float = 2e-3) -> None:
    scale = np.nanmax(np.abs(actual))
    known = np.isfinite(actual)
    assert known.mean() > 0.5
    np.testing.assert_allclose(actual[known], np.broadcast_to(expected, actual.shape)[known], atol=tolerance * scale)


def test_torque_without_effects_is_rigid_body_torque_and_friction(plant: Plant) -> None:
    reference, robot = plant.reference, plant.robot
    rigid = exact_torque(robot.rig.geometry, robot.links, reference.theta, reference.rate, reference.acceleration)
    friction = robot.friction.viscous * reference.rate + np.array(robot.friction.coulomb) * np.sign(reference.rate)
    once = reference.rows[:: reference.per_sample]
    moving = (np.abs(reference.rate[once]) > SLIDING).all(axis=1)
    reported_torque = torque(plant, plant.report())
    np.testing.assert_allclose(
        reported_torque[moving], (rigid + friction)[once][moving], atol=2e-3 * np.abs(reported_torque).max()
    )


FORMULAS: dict[str, tuple[dict[str, float], Callable[[Reported], Floats | float]]] = {
    "torque_offset": ({"a": 0.4}, lambda r: 0.4),
    "asymmetric_viscous": ({"a": 0.3}, lambda r: 0.3 * np.abs(r.velocity)),
    "quadratic_friction": ({"a": 0.2}, lambda r: 0.2 * r.velocity * np.abs(r.velocity)),
    "stribeck": (
        {"a": 0.9, "v_s": 0.5},
        lambda r: 0.9 * np.exp(-((r.velocity / 0.5) ** 2)) * np.sign(r.velocity),
    ),
    "cogging": ({"a": 0.4, "N": 24, "phase": 0.5}, lambda r: 0.4 * np.sin(24 * r.position + 0.5)),
    "joint_spring": ({"k": 2.0, "q_0": 0.3}, lambda r: 2.0 * (r.position - 0.3)),
    "arm_com_offset": ({"a": -0.6}, lambda r: -0.6 * np.sin(r.position)),
    "arm_mass_mismatch": ({"a": 0.6}, lambda r: 0.6 * np.cos(r.position)),
    "uneven_grease": ({"a": 0.3, "phase": 1.0}, lambda r: 0.3 * np.sin(2 * r.position + 1) * r.velocity),
    "bearing_load": ({"a": 0.05}, lambda r: 0.05 * np.abs(r.acceleration) * np.sign(r.velocity)),
    "rubber_stop": ({"a": 9.0, "q_0": -0.1}, lambda r: 9.0 * np.maximum(r.position + 0.1, 0) ** 2),
    "fan": ({"a": 0.5, "f": 7.0, "phase": 0.2}, lambda r: 0.5 * np.sin(2 * np.pi * 7 * time(r) + 0.2)),
    "creeping_zero": ({"a": 0.5, "T": 4.0}, lambda r: 0.5 * (1 - np.exp(-time(r) / 4))),
    "thermal_drift": (
        {"b": 0.5, "viscous": 0.6, "T": 4.0},
        lambda r: 0.5 * (0.6 * r.velocity + np.sign(r.velocity)) * np.exp(-time(r) / 4),
    ),
}


def time(reported: Reported) -> Floats:
    return np.arange(len(reported.position))[:, None] / 500.0


@pytest.mark.parametrize("effect", FORMULAS)
def test_additive_effect_adds_its_formula_on_its_joints(plant: Plant, effect: str) -> None:
    parameters, formula = FORMULAS[effect]
    bare, difference = added_torque(plant, hidden(effect, (1, 3), **parameters))
    assert_close(difference[:, [0, 2]], np.broadcast_to(formula(bare), difference.shape)[:, [0, 2]])
    assert not np.nan_to_num(difference[:, 1]).any()


def test_load_dependent_friction_grows_with_the_load(plant: Plant) -> None:
    reference, robot = plant.reference, plant.robot
    rigid = exact_torque(robot.rig.geometry, robot.links, reference.theta, reference.rate, reference.acceleration)
    bare, difference = added_torque(plant, hidden("load_dependent_friction", a=0.1))
    assert_close(
        difference, 0.1 * np.abs(rigid[reference.rows[:: reference.per_sample]]) * np.sign(bare.velocity), 0.01
    )


def test_presliding_hysteresis_reduces_friction_after_reversals_only(plant: Plant) -> None:
    level = np.array(plant.robot.friction.coulomb)
    bare, difference = added_torque(plant, hidden("presliding_hysteresis", z_s=0.01))
    opposing = difference * np.sign(bare.velocity)
    assert np.nanmax(opposing) < 1e-3
    assert np.nanmin(opposing / level) > -2
    assert np.nanmin(opposing) < -0.2
    shorter = added_torque(plant, hidden("presliding_hysteresis", z_s=0.002))[1]
    assert np.nansum(shorter**2) < 0.2 * np.nansum(difference**2)


def test_base_tilt_turns_gravity(plant: Plant) -> None:
    reference, robot = plant.reference, plant.robot
    gravity = (9.81 * math.sin(0.1), 0.0, -9.81 * math.cos(0.1))
    motion = reference.theta, reference.rate, reference.acceleration
    expected = exact_torque(robot.rig.geometry, robot.links, *motion, gravity)
    expected -= exact_torque(robot.rig.geometry, robot.links, *motion)
    _, difference = added_torque(plant, hidden("base_tilt", angle=0.1, direction=0.0))
    assert_close(difference, expected[reference.rows[:: reference.per_sample]])


def test_payload_change_adds_torque_from_its_instant_on(plant: Plant) -> None:
    bare, difference = added_torque(plant, hidden("payload_change", dm=0.5, t_c=5.0))
    before, after = time(bare)[:, 0] < 4.9, time(bare)[:, 0] > 5.1
    assert np.nanmax(np.abs(difference[before])) < 1e-9
    heavier = plant.robot.links.model_copy(update={"payload": plant.robot.links.payload + 0.5})
    reference, geometry = plant.reference, plant.robot.rig.geometry
    motion = reference.theta, reference.rate, reference.acceleration
    expected = exact_torque(geometry, heavier, *motion) - exact_torque(geometry, plant.robot.links, *motion)
    assert_close(difference[after], expected[reference.rows[:: reference.per_sample]][after])


def test_air_drag_takes_power_from_the_platform(plant: Plant) -> None:
    reference = plant.reference
    bare, difference = added_torque(plant, hidden("air_drag", c=3.0))
    power = (np.nan_to_num(difference) * bare.velocity).sum(axis=1)
    speed = np.linalg.norm(reference.platform_rate[reference.rows[:: reference.per_sample]], axis=1)
    whole = np.isfinite(difference).all(axis=1)
    np.testing.assert_allclose(power[whole], 3.0 * speed[whole] ** 3, atol=0.02 * power.max())


def test_actuation_delay_shifts_the_voltage(plant: Plant) -> None:
    bare, late = plant.report(), plant.report([hidden("actuation_delay", delay=0.004)])
    np.testing.assert_allclose(late.voltage[:-2], bare.voltage[2:], atol=1e-9)


def test_amplifier_effects_change_the_voltage(plant: Plant) -> None:
    bare = plant.report()
    volts, gain = bare.voltage, np.array(plant.robot.rig.torque.gain)
    stronger = plant.report([hidden("torque_gain_mismatch", (2,), mismatch=0.1)]).voltage
    np.testing.assert_allclose(stronger[:, 1] ** 2 * 1.1, volts[:, 1] ** 2, rtol=1e-9)
    np.testing.assert_array_equal(stronger[:, 0], volts[:, 0])
    bent = plant.report([hidden("torque_map_exponent", excess=0.2)]).voltage
    np.testing.assert_allclose(gain * np.abs(bent) ** 2.2, gain * volts**2, rtol=1e-9)
    turning = plant.report([hidden("back_emf", k_e=0.1)]).voltage
    np.testing.assert_allclose(turning - volts, 0.1 * bare.velocity, atol=2e-4)
    dead = plant.report([hidden("amplifier_deadband", width=0.2)]).voltage
    np.testing.assert_allclose(dead - volts, 0.2 * np.sign(volts), atol=1e-9)
    level = 1.2 * np.abs(volts).max()
    commanded = plant.report([hidden("amplifier_saturation", inverse_level=1 / level, n=5.0)]).voltage
    np.testing.assert_allclose(commanded / (1 + np.abs(commanded / level) ** 5) ** 0.2, volts, rtol=1e-9)


def test_encoder_effects_change_the_reported_position(plant: Plant) -> None:
    bare = plant.report()
    shifted = plant.report([hidden("encoder_zero_offset", (1,), c=0.02)])
    np.testing.assert_allclose(shifted.position - bare.position, np.broadcast_to([0.02, 0, 0], bare.position.shape))
    np.testing.assert_allclose(shifted.voltage, bare.voltage)
    wavy = plant.report([hidden("encoder_eccentricity", a=1e-3, N=21, phase=0.4)])
    np.testing.assert_allclose(wavy.position - bare.position, 1e-3 * np.sin(21 * bare.position + 0.4), atol=1e-12)


def test_geometry_error_gives_the_torque_of_the_actual_lengths(plant: Plant) -> None:
    reference, robot = plant.reference, plant.robot
    longer = robot.rig.geometry.model_copy(update={"L2": robot.rig.geometry.L2 + 0.02})
    motion = reference.theta, reference.rate, reference.acceleration
    expected = exact_torque(longer, robot.links, *motion) - exact_torque(robot.rig.geometry, robot.links, *motion)
    _, difference = added_torque(plant, hidden("geometry_error", error=0.02, L2=1.0))
    assert_close(difference, expected[reference.rows[:: reference.per_sample]])


def test_cable_pulls_two_arms_together(plant: Plant) -> None:
    bare, difference = added_torque(plant, hidden("tangled_cables", (1, 3), k=2.0))
    apart = 2.0 * (bare.position[:, 0] - bare.position[:, 2])
    assert_close(difference, np.column_stack([apart, np.zeros_like(apart), -apart]))


def test_joint_elasticity_deflects_by_the_torque_and_accelerates_the_motor(plant: Plant) -> None:
    compliance = 1e-3
    bare, soft = plant.report(), plant.report([hidden("joint_elasticity", compliance=compliance)])
    reference, robot = plant.reference, plant.robot
    links = robot.links.model_copy(update={"motor_inertia": 0.0})
    load = exact_torque(robot.rig.geometry, links, reference.theta, reference.rate, reference.acceleration)
    twist = compliance * load[reference.rows[:: reference.per_sample]]
    np.testing.assert_allclose(soft.position - bare.position, twist, atol=1e-9)
    faster = robot.links.motor_inertia * (soft.acceleration - bare.acceleration)
    faster += robot.friction.viscous * (soft.velocity - bare.velocity)
    moving = (np.abs(bare.velocity) > SLIDING).all(axis=1)
    change = torque(plant, soft) - torque(plant, bare)
    np.testing.assert_allclose(change[moving], faster[moving], atol=0.02 * np.abs(faster).max())


def test_backlash_is_visible_only_where_the_load_changes_sign(plant: Plant, light: Plant) -> None:
    half = 1e-3
    steady, turning = (
        torque(p, p.report([hidden("backlash", b=half)])) - torque(p, p.report()) for p in (plant, light)
    )
    scale = [np.abs(torque(p, p.report())).max() for p in (plant, light)]
    assert np.abs(steady).max() < 0.01 * scale[0]
    assert np.abs(turning).max() > 0.05 * scale[1]


def test_backlash_preserves_the_mean_torque(light: Plant) -> None:
    change = torque(light, light.report([hidden("backlash", b=1e-3)])) - torque(light, light.report())
    # Torque that is missing in the gap is made up at the tooth, so that the arms keep up with the motors.
    assert np.abs(change.sum(axis=0)).max() < 0.05 * np.abs(change).sum(axis=0).min()


@pytest.mark.parametrize("effect", [*library(), *out_of_library.KINDS])
def test_every_effect_has_its_name_and_is_visible_on_its_joints(light: Plant, effect: str) -> None:
    kind = type(build(EffectSpec(name=effect))) if effect in library() else out_of_library.KINDS[effect]
    built = kind(joints=(1, 2)) if kind.between_joints else kind()
    assert name(built) == effect
    bare, changed = light.report(), light.report([built])
    assert np.isfinite(changed.voltage).all()
    difference = np.abs(changed.voltage - bare.voltage) + np.abs(changed.position - bare.position)
    assert (difference.max(axis=0) > 1e-5)[[joint - 1 for joint in built.joints]].all()
