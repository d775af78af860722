import mujoco
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


def test_passive_robot_keeps_its_energy() -> None:
    plant = Plant(GEOMETRY, Links(), integrator="RK4")
    plant.place((0.0, 0.05, -0.85))
    kinetic, total = [], []
    for _ in range(round(1 / 2e-4)):
        plant.step((0.0, 0.0, 0.0))
        mujoco.mj_energyPos(plant.model, plant.data)
        mujoco.mj_energyVel(plant.model, plant.data)
        kinetic.append(plant.data.energy[1])
        total.append(plant.data.energy.sum())
    assert max(kinetic) > 1.0
    assert np.ptp(total) < 1e-4 * max(kinetic)


def test_held_joint_does_not_creep() -> None:
    plant = Plant(GEOMETRY, Links())
    plant.place(ASIDE)
    plant.set_friction((45.0,) * 3)
    torque = (20.0, -30.0, 25.0)
    for _ in range(500):
        plant.step(torque)
    start = np.array(plant.motor_angles())
    for _ in range(500):
        plant.step(torque)
    assert np.abs(np.array(plant.motor_angles()) - start).max() / 0.1 < 1e-6


def test_joint_slides_when_pushed_harder_than_its_friction() -> None:
    plant = Plant(GEOMETRY, Links())
    plant.place(ASIDE)
    plant.set_friction((45.0,) * 3)
    plant.step((0.0,) * 3)
    holding_torque = np.array(plant.rigid_torque())
    plant.set_friction((2.0,) * 3)
    for push, moves in ((1.9, False), (2.1, True)):
        plant.place(ASIDE)
        for _ in range(100):
            plant.step(holding_torque + push)
        assert np.all(np.abs(plant.motor_speeds()) > 1e-3) == moves


def test_viscous_friction_damps_in_proportion_to_speed() -> None:
    plant = Plant(GEOMETRY, Links(), viscous=(0.5, 0.6, 0.7))
    plant.place(ASIDE)
    for _ in range(500):
        plant.step((0.0,) * 3)
    speed = np.array(plant.motor_speeds())
    assert np.all(np.abs(speed) > 0.1)
    assert plant.rigid_torque() == pytest.approx(-np.array([0.5, 0.6, 0.7]) * speed, rel=0.01)
