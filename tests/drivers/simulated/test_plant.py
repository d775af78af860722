import numpy as np
import pytest

from drivers.simulated.config import Links, SimConfig
from drivers.simulated.machine import SimulatedMachine, plant_step
from drivers.simulated.plant import Plant
from recordings.errors import BadInput
from recordings.rig import Geometry, simulated_rig
from tests.drivers.simulated.exact_delta import exact_torque
from trajectories import kinematics
from trajectories.library import load

GEOMETRY = Geometry()
ASIDE = (0.12, -0.08, -0.8)


def test_mechanism_closes_where_the_platform_is_placed() -> None:
    plant = Plant(GEOMETRY, Links())
    plant.place(ASIDE)
    assert np.abs(plant.data.efc_pos[:9]).max() < 1e-12
    assert plant.platform() == pytest.approx(ASIDE, abs=1e-12)
    assert plant.motor_angles() == pytest.approx(kinematics.inverse(GEOMETRY, np.array([ASIDE]))[0], abs=1e-12)
    with pytest.raises(BadInput, match="cannot reach"):
        plant.place((0.0, 0.0, -3.0))


def test_torque_agrees_with_exact_inverse_dynamics_along_fig5a() -> None:
    rig = simulated_rig()
    trajectory = load("fig5a", rig, cycles=1, rate=1 / plant_step(rig.rate))
    machine = SimulatedMachine(rig, SimConfig(), np.random.default_rng(0))
    machine.reset(trajectory.platform[0].tolist())
    machine.enabled, machine.brake = [True] * 3, [False] * 3
    rows = []
    for setpoint in trajectory.joint_position.tolist():
        before = machine.position(), machine.velocity()
        machine.advance([setpoint])
        rows.append((*before, machine.plant.motor_accelerations(), machine.plant.rigid_torque()))
    position, velocity, acceleration, torque = np.moveaxis(np.array(rows)[1000::20], 1, 0)
    exact = exact_torque(rig.geometry, Links(), position, velocity, acceleration)
    rms = np.sqrt(np.mean(exact**2, axis=0))
    assert np.all(rms > 1.0)
    assert np.all(np.sqrt(np.mean((torque - exact) ** 2, axis=0)) < 1e-3 * rms)


def test_viscous_friction_damps_in_proportion_to_speed() -> None:
    plant = Plant(GEOMETRY, Links(), viscous=(0.5, 0.6, 0.7))
    plant.place(ASIDE)
    for _ in range(500):
        plant.step((0.0,) * 3)
    speed = np.array(plant.motor_speeds())
    assert np.all(np.abs(speed) > 0.1)
    assert plant.rigid_torque() == pytest.approx(-np.array([0.5, 0.6, 0.7]) * speed, rel=0.01)
