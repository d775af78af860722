"""A torque that is given, for runs without files and processes."""

from pathlib import Path
from threading import Event

import numpy as np

from daq.feedforward.source import PlannedTorque
from recordings.recording import Floats
from recordings.rig import Rig
from tests.patience import patient
from trajectories import Trajectory
from trajectories.checks import torque_estimate


def write_nominal_torque(path: Path, trajectory: Trajectory, rig: Rig) -> None:
    """Write a table of the torque of the rig's nominal masses along a trajectory."""
    names = ["time", *(f"{quantity}_{joint}" for quantity in ("position", "torque") for joint in (1, 2, 3))]
    rows = np.column_stack([trajectory.time, trajectory.joint_position, torque_estimate(trajectory, rig)])
    np.savetxt(path, rows, "%.12g", ",", header=",".join(names), comments="")


class GivenTorque:
    """A `TorqueSource` with the torque (n, dof) [N m] of the trajectory, and of the approach if it has one."""

    path, digest = Path("given.csv"), "d1"

    def __init__(self, stream: Floats, approach: Floats | None = None, ready: Event | None = None) -> None:
        """`ready`: set when the torque is there."""
        self._stream, self._approach, self._ready = stream, approach, ready
        self.cancelled, self.start = False, 0.0

    def compute(self, start: float, approach: Floats, trajectory: Trajectory) -> PlannedTorque:
        self.start = start
        if self._ready is not None:
            self._ready.wait(patient(30))
        return PlannedTorque(self._approach, self._stream, "d2")

    def cancel(self) -> None:
        self.cancelled = True
        if self._ready is not None:
            self._ready.set()
