"""Motions from files: points in a CSV file, or the coefficients of a Fourier series in a TOML file."""

from pathlib import Path

import numpy as np

from recordings.config import read_toml
from recordings.csv_table import read_table
from recordings.errors import BadInput
from recordings.importing.table import Table
from recordings.recording import Floats
from trajectories import spline
from trajectories.fourier import FourierSeries
from trajectories.motion import PlannedMotion, Space

_MAX_NUMBER = 1e6
"""Largest accepted number [s, m or rad]."""


def read_motion(path: Path) -> PlannedMotion:
    """Read a trajectory file.

    A `.toml` file is a `FourierSeries`. A `.csv` file has the columns time, x, y, z [s, m] or time, joint_1, ...,
    joint_n [s, rad or m], and one row per point, evenly spaced or not. A quintic spline connects the points. The
    motion repeats if the last row has the coordinates of the first.

    Raises:
        BadInput: the file is missing or invalid; the error names the line.
    """
    if path.suffix.lower() == ".toml":
        return read_toml(path, FourierSeries, "trajectory file").motion(path.name)
    table = read_table(path)
    points = np.column_stack(list(table.columns.values()))
    names = list(table.columns)
    space: Space = "platform" if names == ["time", "x", "y", "z"] else "joint"
    joints = range(1, max(len(names), 2))
    if space == "joint" and names != ["time", *(f"joint_{joint}" for joint in joints)]:
        known = "the header 'time,x,y,z' or 'time,joint_1,...,joint_n'"
        raise BadInput(f"{path}, line 1: {known} expected, '{','.join(names)[:60]}' found; correct it")
    _check_points(table, points)
    return spline.through(path.name, f"spline through {len(points)} points", space, points[:, 0], points[:, 1:])


def _check_points(table: Table, points: Floats) -> None:
    wrong = np.argwhere(~(np.abs(points) <= _MAX_NUMBER))
    if len(wrong):
        row, column = wrong[0].tolist()
        raise BadInput(
            f"{table.location(row, list(table.columns)[column])}: seconds, metres or radians below {_MAX_NUMBER:g} "
            f"expected, {points[row, column]:g} found; fill the gap or check the units"
        )
    if len(points) < spline.MIN_POINTS:
        raise BadInput(f"{table.path}: at least {spline.MIN_POINTS} points expected, {len(points)} found; add points")
    backwards = np.diff(points[:, 0]) <= 0
    if backwards.any():
        row = int(np.argmax(backwards)) + 1
        raise BadInput(
            f"{table.location(row)}: time must increase from row to row, {points[row - 1, 0]:g} s is followed by "
            f"{points[row, 0]:g} s; sort the rows and remove duplicates"
        )
