"""Machines with one hidden effect, and their reported and true values along a motion of all joints."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.simulated.config import EffectSpec, Friction, SimConfig
from drivers.simulated.effect import discover
from drivers.simulated.machine import SimulatedMachine, plant_step
from recordings.rig import Rig, Voltage, simulated_rig
from trajectories import load

RIG = simulated_rig()
Floats = NDArray[np.float64]


def reporting(kind: str) -> Rig:
    """The rig whose drives report a kind of voltage."""
    voltage = Voltage.model_validate({"kind": kind})
    return RIG.model_copy(update={"drives": tuple(d.model_copy(update={"voltage": voltage}) for d in RIG.drives)})


def spec_of(name: str, **parameters: float) -> EffectSpec:
    """The effect on joint 2, on joints 1 and 2, or on the whole robot."""
    kind = discover()[name]
    joints = (1, 2, 3) if kind.whole_robot else (1, 2) if kind.between_joints else (2,)
    return EffectSpec(name=name, joints=joints, parameters=parameters)


def powered(config: SimConfig, rig: Rig = RIG) -> SimulatedMachine:
    """A machine with power on and brakes released."""
    machine = SimulatedMachine(rig, config, np.random.default_rng(0))
    machine.enabled, machine.brake = [True] * 3, [False] * 3
    return machine


def machine_with(name: str = "", coulomb: float = 0.0, rig: Rig = RIG, **parameters: float) -> SimulatedMachine:
    """A machine with the effect, without viscous friction, and power on."""
    friction = Friction(viscous=(0.0,) * 3, coulomb=(coulomb,) * 3)
    return powered(SimConfig(friction=friction, effects=(spec_of(name, **parameters),) if name else ()), rig)


def held_torque(machine: SimulatedMachine, theta: Floats, seconds: float = 0.5) -> Floats:
    """Motor torques (3,) after holding the joint angles `theta` [rad] for `seconds` [s]."""
    machine.advance([theta.tolist()] * round(seconds / machine.dt))
    return np.array(machine.torque())


@dataclass(frozen=True, eq=False)
class Run:
    """Motion (n, 3) of all joints: the state before each step."""

    t: Floats
    q: Floats
    v: Floats
    a: Floats
    load: Floats
    reported: Floats
    """Torque of the reported voltages."""
    motor_torque: Floats
    """Torque of the motors."""
    added: Floats
    """Part of the motor torque that does not reach the rigid robot."""


def swing(machine: SimulatedMachine) -> Run:
    """Swing all joints for 0.8 s, at different frequencies."""
    start = np.array(machine.position())
    held_torque(machine, start, 0.2)
    time = np.arange(4000) * machine.dt
    swing = np.sin(2 * np.pi * time[:, None] * [1.0, 1.2, 0.8]) * [0.25, 0.3, 0.2]
    return follow(machine, start + swing * np.minimum(time[:, None] / 0.2, 1.0))


def follow(machine: SimulatedMachine, setpoints: Floats) -> Run:
    """Follow the setpoints (n, 3), one in each step."""
    rows, plant = [], machine.plant
    for setpoint in setpoints.tolist():
        before = (plant.motor_angles(), plant.motor_speeds(), plant.motor_accelerations(), plant.rigid_torque())
        t = machine.time
        machine.advance([setpoint])
        motor_torque = machine.torque()
        added = np.subtract(motor_torque, plant.rigid_torque())
        rows.append(([t] * 3, *before, machine.reported_torque(), motor_torque, added))
    t, q, v, a, load, reported, motor_torque, added = np.moveaxis(np.array(rows), 1, 0)
    return Run(t=t[:, 0], q=q, v=v, a=a, load=load, reported=reported, motor_torque=motor_torque, added=added)


def along_fig5a(config: SimConfig) -> Run:
    """One repetition of fig5a, with its lead-in and lead-out; the machine keeps up to the end."""
    trajectory = load("fig5a", RIG, cycles=1, rate=1 / plant_step(RIG.rate))
    x, y, z = trajectory.platform[0].tolist()
    machine = powered(config.model_copy(update={"park": (x, y, z)}))
    run = follow(machine, trajectory.joint_position)
    assert np.abs(machine.following_error()).max() < RIG.limits.following_error
    return run
