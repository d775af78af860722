"""Repetitions of an imported motion: numbered in the file, or found from the motion itself."""

import numpy as np

from recordings.cycles import find_cycles
from recordings.errors import BadInput
from recordings.importing.table import Table
from recordings.interpolation import interpolate_columns
from recordings.recording import Floats, Ints

_MAX_GAPS = 1.15
"""Repetitions are not searched in a recording that lasts this many times longer than its samples: gaps prevail."""


def repetitions(table: Table, cycle: str | None, stamp: Ints, motion: Floats) -> tuple[Ints, float]:
    """Repetition index of each sample (n,), -1 outside of repetitions, and the period [s], 0 without repetitions.

    Args:
        cycle: column with the number of the repetition; None: repetitions are found from `motion` (n, dof).
        stamp: (n,) time [ns].

    Raises:
        BadInput: a number of a repetition is not whole.
    """
    if cycle is not None:
        return _numbered(table, cycle, stamp)
    step = mean_step(stamp)
    if stamp[-1] > _MAX_GAPS * step * len(stamp):
        return np.full(len(stamp), -1), 0.0
    grid = np.arange(0, stamp[-1] + step / 2, step)
    cycles = find_cycles(interpolate_columns(grid, stamp, motion))
    if cycles is None:
        return np.full(len(stamp), -1), 0.0
    # Half a step is added, so that rounding cannot move a sample at a boundary to the wrong repetition.
    since = stamp + step / 2 - grid[cycles.first]
    repeat = np.floor(since / (cycles.period * step)).astype(np.int64)
    return np.where((repeat >= 0) & (repeat < cycles.count), repeat, -1), cycles.period * step / 1e9


def mean_step(stamp: Ints) -> float:
    """Time between samples [ns] of the times `stamp` (n,) [ns], of which a gap holds several.

    The median alone is wrong by what stamps are rounded to, which adds up over a recording.
    """
    steps = np.diff(stamp)
    median = float(np.median(steps))
    return float(steps.sum() / np.maximum(np.rint(steps / median), 1).sum())


def _numbered(table: Table, name: str, stamp: Ints) -> tuple[Ints, float]:
    cycle = np.nan_to_num(table.column(name), nan=-1.0)
    wrong = np.flatnonzero((cycle != np.rint(cycle)) | (np.abs(cycle) > 2**31))
    if len(wrong):
        row = int(wrong[0])
        raise BadInput(
            f"{table.location(row, name)}: a whole number expected, {float(cycle[row])!r} found; correct it"
        )
    inside = cycle >= 0
    numbers, rank = np.unique(cycle[inside], return_inverse=True)
    repeat = np.full(len(cycle), -1)
    repeat[inside] = rank
    first = [int(stamp[np.argmax(repeat == number)]) for number in range(len(numbers))]
    return repeat, float(np.median(np.diff(first))) / 1e9 if len(first) > 1 else 0.0
