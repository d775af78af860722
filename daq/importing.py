"""Conversion of measurements of other programs, in the CSV format of docs/reference/recordings.md, to recordings."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from daq.columns import JOINT_COLUMNS
from recordings import blocks
from recordings.blocks import SampleTable
from recordings.config import validated
from recordings.csv_table import CsvTable, read_table
from recordings.cycles import find_cycles
from recordings.errors import BadInput
from recordings.imported import imported_rig, measured_torque
from recordings.recording import Floats, Ints, Run
from recordings.rig import JointType, MechanismName, Rig, Torque

_JOINT_COLUMN = re.compile(rf"({'|'.join((*JOINT_COLUMNS, 'current'))})_([1-9]\d*)")
_MAX_TIME = 2**31
"""Largest time that a ROS time stamp holds [s]."""
_MAX_RATE = 4000.0
"""Highest rate that a rig description permits [Hz]."""


@dataclass(frozen=True)
class Description:
    """Description of the machine, given in addition to the measurements."""

    rig: Rig | None = None
    mechanism: MechanismName | None = None
    joints: tuple[JointType, ...] = ("revolute",)
    torque: Mapping[str, Any] | None = None
    """Keys of the section [torque] of a rig file; None if they are unknown."""
    gravity: bool = False
    """Whether gravity loads the joint of a single axis."""
    simulated: bool = False


@dataclass(frozen=True, eq=False)
class Imported:
    """Result of importing a CSV file."""

    rig: Rig
    run: Run
    samples: SampleTable

    @property
    def steps(self) -> Floats:
        """Time steps between the samples (n - 1,) [s]."""
        return np.diff(self.samples.stamp) / 1e9


def import_csv(path: Path, out: Path, description: Description) -> Imported:
    """Write the measurements in `path` to the new recording `out`.

    Time is counted from the first sample. Uneven time steps are kept.

    Raises:
        BadInput: the file violates the format or contradicts the description, or `out` exists.
        OSError: `out` cannot be written; no partial file is left.
    """
    table = read_table(path)
    stamp = _stamps(table)
    joints = _joints(table)
    position = joints["position"]
    rate = float(1e9 / np.median(np.diff(stamp)))
    rig = _rig(table, description, joints, rate)
    if not {"voltage", "effort"} & joints.keys():
        joints["effort"] = _effort(table, joints["current"], rig)
    repeat, period = _repeat(table, stamp, joints.get("command", position))
    run = Run(
        trajectory="imported",
        trajectory_digest=table.digest,
        period=period,
        cycles=max(int(repeat.max()) + 1, 1),
        rate=rate,
        software=f"delta-workbench {version('delta-workbench')}",
        simulated=description.simulated,
        pace="realtime",
        start="1970-01-01T00:00:00.000+00:00",
        exit_status=0,
        reason=f"imported from {path.name}",
    )
    samples = SampleTable(
        joints=rig.joint_names,
        stamp=stamp,
        log=stamp,
        cycle=np.arange(len(stamp)),
        repeat=repeat,
        extra={name: column for name, column in table.columns.items() if _is_extra(name)},
        position=position,
        command=joints.get("command"),
        voltage=joints.get("voltage"),
        velocity=joints.get("velocity"),
        effort=joints.get("effort"),
    )
    blocks.write(out, rig, run, samples)
    return Imported(rig, run, samples)


def _is_extra(name: str) -> bool:
    quantity = _JOINT_COLUMN.fullmatch(name)
    return name not in ("time", "cycle") and (quantity is None or quantity[1] == "current")


def _stamps(table: CsvTable) -> Ints:
    """Time stamps (n,) [ns] from the first sample."""
    if "time" not in table.columns:
        raise BadInput(f"{table.path}, line 1: a column 'time' expected, {', '.join(table.columns)} found; rename it")
    time = table.columns["time"]
    if len(time) < 2:
        raise BadInput(f"{table.path}: at least two samples expected, {len(time)} found")
    if np.isnan(time).any():
        raise BadInput(f"{table.location(int(np.argmax(np.isnan(time))), 'time')}: a time expected, none found")
    # Whole seconds are split off, so that times since 1970 keep the full float resolution of their fractions.
    seconds = np.floor(time)
    if seconds[-1] - seconds[0] >= _MAX_TIME:
        raise BadInput(f"{table.path}: times in seconds within {_MAX_TIME} s expected; check the unit")
    relative = (seconds - seconds[0]).astype(np.int64) * 10**9 + np.rint((time - seconds) * 1e9).astype(np.int64)
    stamp: Ints = relative - relative[0]
    wrong = np.flatnonzero(np.diff(stamp) <= 0)
    if len(wrong):
        row = int(wrong[0]) + 1
        raise BadInput(
            f"{table.location(row, 'time')}: a time after {float(time[row - 1])!r} s expected, {float(time[row])!r} "
            "found; sort the rows and remove those that stand twice"
        )
    return stamp


def _joints(table: CsvTable) -> dict[str, Floats]:
    """Joint quantities (n, dof) in the file, by name."""
    numbers: dict[str, set[int]] = {}
    for name in table.columns:
        if match := _JOINT_COLUMN.fullmatch(name):
            numbers.setdefault(match[1], set()).add(int(match[2]))
    dof = max(numbers.get("position", {0}))
    if not dof:
        raise BadInput(f"{table.path}, line 1: columns position_1, position_2, ... expected, none found; rename them")
    for name, present in numbers.items():
        expected = set(range(1, dof + 1))
        if wrong := sorted(present ^ expected):
            problem = "is missing" if wrong[0] in expected else f"has no position_{wrong[0]}"
            raise BadInput(
                f"{table.path}, line 1: one column {name}_i for each position_i expected, {name}_{wrong[0]} {problem}"
            )
    if not {"voltage", "effort", "current"} & numbers.keys():
        raise BadInput(
            f"{table.path}, line 1: columns voltage_1 ..., effort_1 ... or current_1 ... expected, none found"
        )
    return {name: np.column_stack([table.columns[f"{name}_{i + 1}"] for i in range(dof)]) for name in numbers}


def _effort(table: CsvTable, current: Floats, rig: Rig) -> Floats:
    """Effort (n, dof) [N m or N] of the `current` (n, dof) [A]."""
    if not rig.torque.per_ampere:
        raise BadInput(
            f"{table.path} holds currents: their torque per ampere expected, none found; give --kt, or "
            "torque.per_ampere in the rig file"
        )
    effort: Floats = current * np.array(rig.torque.per_ampere)
    return effort


def _rig(table: CsvTable, description: Description, joints: Mapping[str, Floats], rate: float) -> Rig:
    dof, volts = joints["position"].shape[1], "voltage" in joints
    if description.rig is not None:
        if description.rig.dof != dof:
            raise BadInput(
                f"{table.path}: {description.rig.dof} joints expected by the rig file, {dof} columns position_i found"
            )
        return description.rig
    if not volts and {"map", "gain"} & (description.torque or {}).keys():
        raise BadInput(f"{table.path} holds no voltages, which alone need a torque map or gain; leave these out")
    if dof != 3 and description.mechanism is None:
        raise BadInput(
            f"{table.path}: the three joints of a delta robot expected, {dof} found; say what it is with --rig, or "
            "with --mechanism axes --joints revolute|prismatic"
        )
    given = validated(dict(description.torque or {}), Torque, "--torque-map, --gain, --kt")
    return imported_rig(
        table.path.stem,
        dof,
        min(rate, _MAX_RATE),
        mechanism=description.mechanism,
        joints=description.joints,
        torque=given if volts else measured_torque(dof, given.per_ampere),
        gravity=description.gravity,
    )


def _repeat(table: CsvTable, stamp: Ints, motion: Floats) -> tuple[Ints, float]:
    """Repetition index of each sample (n,), -1 outside of repetitions, and the period [s], 0 without repetitions."""
    if "cycle" in table.columns:
        return _repeat_from_column(table, stamp)
    step = float(np.median(np.diff(stamp)))
    grid = np.arange(0, stamp[-1] + step / 2, step)
    cycles = find_cycles(_interpolated(grid, stamp, motion))
    if cycles is None:
        return np.full(len(stamp), -1), 0.0
    # Half a step is added, so that rounding cannot move a sample at a boundary to the wrong repetition.
    since = stamp + step / 2 - grid[cycles.first]
    repeat = np.floor(since / (cycles.period * step)).astype(np.int64)
    return np.where((repeat >= 0) & (repeat < cycles.count), repeat, -1), cycles.period * step / 1e9


def _interpolated(grid: Floats, stamp: Ints, motion: Floats) -> Floats:
    """Linear interpolation of `motion` (n, dof) at the instants `grid` [ns]; NaN for a joint never measured."""
    known = np.isfinite(motion)
    return np.column_stack(
        [
            np.interp(grid, stamp[k], column[k]) if k.any() else np.full(len(grid), np.nan)
            for column, k in zip(motion.T, known.T, strict=True)
        ]
    )


def _repeat_from_column(table: CsvTable, stamp: Ints) -> tuple[Ints, float]:
    cycle = np.nan_to_num(table.columns["cycle"], nan=-1.0)
    wrong = np.flatnonzero((cycle != np.rint(cycle)) | (np.abs(cycle) > 2**31))
    if len(wrong):
        row = int(wrong[0])
        raise BadInput(f"{table.location(row, 'cycle')}: a whole number expected, {float(cycle[row])!r} found")
    inside = cycle >= 0
    numbers, rank = np.unique(cycle[inside], return_inverse=True)
    repeat = np.full(len(cycle), -1)
    repeat[inside] = rank
    first = [int(stamp[np.argmax(repeat == number)]) for number in range(len(numbers))]
    return repeat, float(np.median(np.diff(first))) / 1e9 if len(first) > 1 else 0.0
