"""Rows of a model's residual, from a whole recording or a window of one, and their means over blocks.

Each cycle of the motion is cut into places of the same length; a block is a visit of one of them.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ident.basics import filters, slicing
from ident.data.prepared_recording import PreparedRecording
from ident.data.row_weights import moving_rows, standstill_share
from recordings.recording import Bools, Floats, Ints

_LIMITED = 0x0800
"""Bit of the statusword by which a drive says that it cannot do what it is asked (CiA 402: internal limit)."""
_MIN_SHARE = 0.5
"""Share of a block's rows that must count, so that a joint's mean is one of this place."""


@dataclass(frozen=True, eq=False)
class Rows:
    """m rows of a recording."""

    time: Floats
    """(m,) [s]"""
    cycle: Ints
    """(m,) number of the repetition; -1 outside of the repeated motion."""
    phase: Floats
    """(m,) time since the beginning of the repetition [s]."""
    residual: Floats
    """(m, dof) measured minus computed torque [N m or N]; NaN where a row is not usable."""
    counted: Bools
    """(m, dof) whether the joint moves and its drive is not at a limit."""
    measured: Floats
    """(m, dof) torque [N m or N]."""
    position: Floats
    """(m, dof) [rad or m]"""
    velocity: Floats
    """(m, dof) [rad/s or m/s]"""
    temperature: Floats
    """(m, dof) of the drives [degC]; NaN where it was not measured."""


def rows_of(prepared: PreparedRecording, computed: Floats) -> Rows:
    """The rows of a recording, for which a model has `computed` the torque (m, dof)."""
    motion = prepared.motion
    moving = moving_rows(prepared, standstill_share(prepared))
    recording, reach = prepared.recording, filters.REACH / prepared.bandwidth
    limited = prepared.start + recording.time[(recording.statusword & _LIMITED).any(axis=1)]
    begin, end = (
        np.searchsorted(limited, prepared.time - reach),
        np.searchsorted(limited, prepared.time + reach, "right"),
    )
    return Rows(
        time=prepared.time,
        cycle=prepared.repeat,
        phase=prepared.phase,
        residual=prepared.torque - computed,
        counted=moving & (begin == end)[:, None],
        measured=prepared.torque,
        position=motion.position,
        velocity=motion.velocity,
        temperature=prepared.temperature[:: prepared.preprocessed.decimation],
    )


@dataclass(frozen=True, eq=False)
class Visit:
    """One visit of a place; its values are means (dof,)."""

    time: float
    """Of its first row [s]."""
    cycle: int
    place: int
    residual: Floats
    """[N m or N]; NaN for a joint of which too few rows count."""
    motion: Floats
    """(2 dof,) position and velocity."""
    direction: Ints
    """1 where the joint moves forward, else 0."""
    temperature: Floats


class BlockMaker:
    """Cuts rows into blocks as they come."""

    def __init__(self, period: float, places: int) -> None:
        """`period` of the motion [s], cut into so many `places`."""
        self._period, self._places = period, places
        self._rest: Rows | None = None

    def blocks(self, rows: Rows) -> Iterator[Visit]:
        """Yield the blocks that are complete with the next `rows`."""
        rows = slicing.along_time(rows, (rows.cycle >= 0) & np.isfinite(rows.phase))
        if self._rest is not None:
            rows = slicing.concatenated([self._rest, rows])
        if not len(rows.time):
            return
        place = np.minimum((rows.phase / self._period * self._places).astype(np.int64), self._places - 1)
        edges = np.flatnonzero(np.diff(rows.cycle * self._places + place)) + 1
        bounds = [0, *edges.tolist()]
        for first, end in pairwise(bounds):
            yield _block(slicing.along_time(rows, slice(first, end)), int(place[first]))
        self._rest = slicing.along_time(rows, slice(bounds[-1], None))


def _block(rows: Rows, place: int) -> Visit:
    known: Bools = rows.counted & np.isfinite(rows.residual)
    count = known.sum(axis=0)
    total = np.where(known, rows.residual, 0.0).sum(axis=0)
    enough = count >= max(1, _MIN_SHARE * len(rows.time))
    return Visit(
        time=float(rows.time[0]),
        cycle=int(rows.cycle[0]),
        place=place,
        residual=np.where(enough, total / np.maximum(count, 1), np.nan),
        motion=np.concatenate([rows.position.mean(axis=0), rows.velocity.mean(axis=0)]),
        direction=(rows.velocity.sum(axis=0) > 0).astype(np.int64),
        temperature=rows.temperature.mean(axis=0),
    )
