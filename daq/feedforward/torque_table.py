"""Table of the torque along a path: `time`, `position_i`, `torque_i`, as `ident torque` writes it."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from recordings.csv_table import read_table
from recordings.errors import BadInput
from recordings.interpolation import interpolate_columns
from recordings.recording import Floats
from recordings.rig import Rig

_TOLERANCE = 1e-3
"""Largest distance of the table's path from the targets [rad]."""


@dataclass(frozen=True, eq=False)
class TorqueTable:
    """Torque at n instants of a path."""

    path: Path
    digest: str
    time: Floats
    """(n,) [s], increasing."""
    position: Floats
    """(n, dof) [rad]."""
    torque: Floats
    """(n, dof) [N m]."""

    def along(self, time: Floats, targets: Floats) -> Floats:
        """Torque (m, dof) [N m] at the instants (m,) [s] of the targets (m, dof) [rad].

        Raises:
            BadInput: the table ends before, or is one of another path.
        """
        start, end = self.time[0], self.time[-1]
        if start > time[0] + 1e-9 or end < time[-1] - 1e-9:
            raise BadInput(
                f"{self.path}: a table from {time[0]:g} to {time[-1]:.6g} s expected, as long as the motion, "
                f"{start:g} to {end:.6g} s found; compute it for this motion, with its --cycles"
            )
        away = np.abs(interpolate_columns(time, self.time, self.position) - targets)
        if away.max() > _TOLERANCE:
            row, joint = np.unravel_index(int(away.argmax()), away.shape)
            raise BadInput(
                f"{self.path}: the path of this motion expected, joint {joint + 1} is {away.max():.4f} rad away from "
                f"it at t = {time[row]:.3f} s; compute the table for this motion and rig"
            )
        return interpolate_columns(time, self.time, self.torque)


def read_torque_table(path: Path, rig: Rig) -> TorqueTable:
    """Read a table; refuse one that this rig may not be given.

    Raises:
        BadInput: the file cannot be read, columns or values are missing, the time does not increase, or a torque is
            larger than limits.torque.
    """
    table = read_table(path)
    joints = range(1, rig.dof + 1)
    names = ["time", *(f"{quantity}_{joint}" for quantity in ("position", "torque") for joint in joints)]
    missing = [name for name in names if name not in table.columns]
    if missing:
        raise BadInput(f"{path}: the columns {', '.join(names)} expected, no {missing[0]} found")
    for name in names:
        gaps = np.isnan(table.columns[name])
        if gaps.any():
            raise BadInput(f"{table.location(int(gaps.argmax()), name)}: a number expected, a gap found")
    time = table.columns["time"]
    if len(time) < 2 or not (np.diff(time) > 0).all():
        raise BadInput(f"{path}: at least two rows with increasing times expected; compute the table anew")
    position, torque = (
        np.column_stack([table.columns[f"{quantity}_{joint}"] for joint in joints])
        for quantity in ("position", "torque")
    )
    _refuse_beyond_limits(path, rig, time, torque)
    return TorqueTable(path, table.digest, time, position, torque)


def _refuse_beyond_limits(path: Path, rig: Rig, time: Floats, torque: Floats) -> None:
    row, joint = np.unravel_index(int(np.abs(torque).argmax()), torque.shape)
    largest, limit = float(torque[row, joint]), rig.limits.torque
    if abs(largest) > limit:
        raise BadInput(
            f"{path}: torque within ±{limit:g} N m expected (limits.torque), {largest:.1f} N m found for joint "
            f"{joint + 1} at t = {time[row]:.3f} s; check the model, or slow the motion down"
        )
