"""Motions from files: points in a CSV file, or the coefficients of a Fourier series in a TOML file."""

import csv
from pathlib import Path

import numpy as np

from recordings.config import read_toml
from recordings.errors import BadInput
from recordings.recording import Floats
from trajectories import spline
from trajectories.fourier import FourierSeries
from trajectories.motion import PlannedMotion, Space

HEADERS: dict[tuple[str, ...], Space] = {
    ("time", "x", "y", "z"): "platform",
    ("time", "joint_1", "joint_2", "joint_3"): "joint",
}
"""Columns of a CSV trajectory; time in s, platform in m, joints in rad."""


_MAX_NUMBER = 1e6
"""Largest accepted number [s, m or rad]."""


def read_motion(path: Path) -> PlannedMotion:
    """Read a trajectory file.

    A `.toml` file is a `FourierSeries`. A `.csv` file has one of HEADERS and one row per point, evenly spaced or not.
    A quintic spline connects the points. The motion repeats if the last row has the coordinates of the first.

    Raises:
        BadInput: the file is missing or invalid; the error names the line.
    """
    if path.suffix.lower() == ".toml":
        return read_toml(path, FourierSeries, "trajectory file").motion(path.name)
    lines = _read_lines(path)
    space = _space(path, lines)
    table = np.array([_numbers(path, number, fields) for number, fields in lines[1:]]).reshape(-1, 4)
    _check_points(path, [number for number, _ in lines[1:]], table)
    return spline.through(path.name, f"spline through {len(table)} points", space, table[:, 0], table[:, 1:])


def _read_lines(path: Path) -> list[tuple[int, list[str]]]:
    """Line number and fields of every non-empty line."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(file)
            return [(reader.line_num, fields) for fields in reader if any(field.strip() for field in fields)]
    except FileNotFoundError:
        raise BadInput(f"trajectory file {path} does not exist; check the path") from None
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise BadInput(f"trajectory file {path} cannot be read as CSV: {error}") from None


def _space(path: Path, lines: list[tuple[int, list[str]]]) -> Space:
    header = tuple(field.strip() for field in lines[0][1]) if lines else ()
    if header not in HEADERS:
        known = " or ".join(f"'{','.join(names)}'" for names in HEADERS)
        raise BadInput(f"{path}, line 1: the header {known} expected, '{','.join(header)[:60]}' found")
    return HEADERS[header]


def _numbers(path: Path, line: int, fields: list[str]) -> list[float]:
    try:
        numbers = [float(field) for field in fields]
    except ValueError:
        numbers = []
    if len(numbers) != 4 or not np.isfinite(numbers).all():
        raise BadInput(f"{path}, line {line}: four finite numbers expected, '{','.join(fields)[:60]}' found")
    if max(map(abs, numbers)) > _MAX_NUMBER:
        raise BadInput(
            f"{path}, line {line}: seconds, metres or radians below {_MAX_NUMBER:g} expected, "
            f"'{','.join(fields)[:60]}' found; check the units"
        )
    return numbers


def _check_points(path: Path, lines: list[int], table: Floats) -> None:
    if len(table) < spline.MIN_POINTS:
        raise BadInput(f"{path}: at least {spline.MIN_POINTS} points expected, {len(table)} found; add points")
    backwards = np.diff(table[:, 0]) <= 0
    if backwards.any():
        row = int(np.argmax(backwards)) + 1
        raise BadInput(
            f"{path}, line {lines[row]}: time must increase from row to row, {table[row - 1, 0]:g} s is followed by "
            f"{table[row, 0]:g} s; sort the rows and remove duplicates"
        )
