import numpy as np
import pytest

from drivers.simulated.config import ROBOTS, load_sim
from drivers.simulated.machine import Machine
from recordings.recording import Floats
from recordings.rig import simulated_rig
from trajectories.library import load


def _torque_along_fig5a(name: str) -> Floats:
    """(n, 3) of one repetition."""
    rig = simulated_rig()
    machine = Machine(rig, load_sim(ROBOTS / f"{name}.toml"), np.random.default_rng(0))
    trajectory = load("fig5a", rig, cycles=1, rate=1 / machine.dt)
    machine.reset(trajectory.platform[0].tolist())
    machine.enabled, machine.brake = [True] * 3, [False] * 3
    rows = []
    for setpoint in trajectory.joint_position.tolist():
        machine.advance([setpoint])
        rows.append(machine.torque())
    assert np.abs(machine.following_error()).max() < rig.limits.following_error
    return np.array(rows)[trajectory.repeat == 0]


def test_torque_of_the_light_robot_changes_its_sign() -> None:
    torque = _torque_along_fig5a("light")
    negative = np.mean(torque < 0, axis=0)
    assert np.all((negative > 0.2) & (negative < 0.5))
    assert np.sqrt(np.mean(torque**2, axis=0)) == pytest.approx([1.4] * 3, rel=0.1)


def test_torque_of_the_heavy_robot_keeps_its_sign() -> None:
    torque = _torque_along_fig5a("heavy")
    assert np.all(torque > 0)
    assert np.sqrt(np.mean(torque**2, axis=0)) == pytest.approx([15.0] * 3, rel=0.1)
