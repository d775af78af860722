"""Backlash and elasticity between motor and arm."""

import numpy as np
import pytest

from drivers.simulated.config import EffectSpec, Links, Servo, SimConfig
from drivers.simulated.machine import SimulatedMachine
from drivers.simulated.plant import Plant
from recordings.rig import simulated_rig
from tests.drivers.simulated.exact_delta import exact_torque

RIG = simulated_rig()
B, COMPLIANCE = 0.004, 5e-4
BACKLASH = EffectSpec(name="backlash", joints=(2,), parameters={"b": B})
ELASTICITY = EffectSpec(name="joint_elasticity", joints=(2,), parameters={"compliance": COMPLIANCE})


def _machine(*effects: EffectSpec) -> SimulatedMachine:
    return SimulatedMachine(RIG, SimConfig(servo=Servo(brake_torque=1e4), effects=effects), np.random.default_rng(0))


def _arm_angles(plant: Plant) -> np.ndarray:
    """Angles of the arms [rad], which differ from the motors' by the couplings."""
    angles = np.array(plant.motor_angles())
    for joint in map(plant.model.joint, range(plant.model.njnt)):
        if joint.name.startswith("twist_"):
            angles[int(joint.name.split("_")[1])] += plant.data.joint(joint.name).qpos[0]
    return angles


def _twist(machine: SimulatedMachine) -> np.ndarray:
    return _arm_angles(machine.plant) - machine.position()


def _rest(machine: SimulatedMachine, seconds: float = 0.5) -> None:
    machine.advance([machine.position()] * round(seconds / machine.dt))


def _weight_on_joint_2(machine: SimulatedMachine) -> float:
    arms, still = _arm_angles(machine.plant)[None], np.zeros((1, 3))
    return float(exact_torque(RIG.geometry, Links(), arms, still, still)[0, 1])


def test_arm_rests_on_either_side_of_the_gap_while_the_encoder_stands() -> None:
    machine = _machine(BACKLASH)
    start = machine.position()[1]
    assert _twist(machine) == pytest.approx([0.0, -B, 0.0], abs=1e-6)
    machine.plant.model.opt.gravity = (0.0, 0.0, 9.81)
    _rest(machine)
    assert _twist(machine) == pytest.approx([0.0, B, 0.0], abs=1e-6)
    assert machine.position()[1] == pytest.approx(start, abs=1e-6)


@pytest.mark.parametrize(("effects", "gap"), [((ELASTICITY,), 0.0), ((BACKLASH, ELASTICITY), B)])
def test_twist_of_the_spring_is_proportional_to_the_torque_and_adds_to_a_gap(
    effects: tuple[EffectSpec, ...], gap: float
) -> None:
    machine = _machine(*effects)
    _rest(machine)
    weight = _weight_on_joint_2(machine)
    assert weight > 3.0
    assert _twist(machine) == pytest.approx([0.0, -gap - weight * COMPLIANCE, 0.0], rel=1e-3, abs=1e-9)


def test_motor_inertia_is_unchanged_by_elasticity() -> None:
    """In the first step after a push, before the spring reacts, the motor moves alone."""
    machine = _machine(EffectSpec(name="joint_elasticity", joints=(2,), parameters={"compliance": 1.5e-3}))
    plant = machine.plant
    plant.set_friction((45.0, 0.0, 45.0))
    holding_torque = [0.0, _weight_on_joint_2(machine), 0.0]
    plant.step(holding_torque)
    still = plant.motor_accelerations()[1]
    plant.step([0.0, holding_torque[1] + 20.0, 0.0])
    assert plant.motor_accelerations()[1] - still == pytest.approx(20.0 / Links().motor_inertia, rel=0.01)


def test_stiffer_than_the_time_step_allows_is_rigid() -> None:
    barely = EffectSpec(name="joint_elasticity", joints=(2,), parameters={"compliance": 1e-7})
    for effects in ((), (barely,)):
        assert np.all(_twist(_machine(*effects)) == 0.0)
