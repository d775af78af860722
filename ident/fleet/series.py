"""Time series of every parameter, effect and error of each robot, from the rows of a store."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np
import pyarrow as pa

from ident.fleet.recording_rows import Row
from recordings.recording import Bools, Floats, Ints

KINDS = ("parameter", "effect", "error")
"""Kinds of rows that are watched; a noise floor is shown beside the error."""
SAME_MOTION = 0.02
"""Two motions are the same if their features differ by less than this share of the largest deviation."""
_LARGEST_HALF_WIDTH = 0.5
"""A positive quantity known better than this, relative, is watched on a logarithmic scale: friction changes by a
factor with temperature."""
_DAY = 86400.0


@dataclass(frozen=True, eq=False)
class Nights:
    """The n usable recordings of one robot, in the order of time."""

    robot: str
    keys: tuple[str, ...]
    paths: tuple[str, ...]
    day: Floats
    """(n,) start [days since 1970]."""
    motion: Ints
    """(n,) number of the motion, from 0."""


@dataclass(frozen=True, eq=False)
class Series:
    """One quantity over the n nights of one robot; NaN where a recording does not show it."""

    nights: Nights
    kind: str
    name: str
    joint: int | None
    """From 1; None: of the whole robot."""
    unit: str
    value: Floats
    low: Floats
    """(n,) 95 % interval."""
    high: Floats
    temperature: Floats
    """(n,) [degC]; NaN where it was not measured."""
    common: Floats
    """(n,) what the same quantity of the other robots did, relative; NaN: too few robots, or not needed."""

    @property
    def known(self) -> Bools:
        """(n,) nights in which it was measured."""
        return np.isfinite(self.value)


def logarithmic(value: Floats, half: Floats) -> bool:
    """Whether a quantity with these values and half intervals (n,) is watched by its logarithm."""
    return bool((value > 0).all() and np.median(half / value) < _LARGEST_HALF_WIDTH)


def moment(day: float) -> datetime:
    """The time (UTC) so many days after 1970, without a zone."""
    return datetime.fromtimestamp(day * _DAY, UTC).replace(tzinfo=None)


def day_of(start: datetime) -> float:
    """The time of a start [days since 1970]."""
    return start.timestamp() / _DAY


def nights_and_series(table: pa.Table, kinds: Sequence[str] = KINDS) -> tuple[list[Nights], list[Series]]:
    """The nights of every robot, sorted by its name, and all series of these `kinds`. table: rows of one settings."""
    of_robot: dict[str, list[Row]] = defaultdict(list)
    values: dict[str, dict[str, Row]] = defaultdict(dict)
    rows = [row for row in table.to_pylist() if row["status"] == "done"]
    for row in rows:
        if row["kind"] == "recording":
            of_robot[row["robot"]].append(row)
        elif row["kind"] in kinds:
            values[row["key"]][row["name"]] = row
    nights = [_nights(robot, of_robot[robot]) for robot in sorted(of_robot)]
    return nights, [series for each in nights for series in _series(each, values)]


def _nights(robot: str, recordings: list[Row]) -> Nights:
    recordings = sorted(recordings, key=lambda row: (row["start"], row["key"]))
    return Nights(
        robot,
        tuple(row["key"] for row in recordings),
        tuple(row["path"] for row in recordings),
        np.array([day_of(row["start"]) for row in recordings]),
        np.array([row["motion_number"] for row in recordings], np.int64),
    )


def day_of_date(date: str) -> float:
    """The begin of a date as 2026-03-14 (UTC) [days since 1970]."""
    return day_of(datetime.fromisoformat(f"{date}T00:00+00:00"))


def motion_number(features: Sequence[float], known: list[list[float]]) -> int:
    """Number of the motion with these `features`: the same one has the same number; a new one is added to `known`."""
    feature = np.array(features)
    # Angles are compared with how far the joints move, periods with the period.
    scale = np.r_[max(feature[0], 1e-9), np.full(len(feature) - 1, max(feature[1:].max(initial=0.0), 1e-9))]
    for number, other in enumerate(known):
        if len(other) == len(feature) and (np.abs(other - feature) < SAME_MOTION * scale).all():
            return number
    known.append(list(features))
    return len(known) - 1


def _series(nights: Nights, values: dict[str, dict[str, Row]]) -> Iterator[Series]:
    names = sorted({name for key in nights.keys for name in values[key]})
    for name in names:
        rows = [values[key].get(name) for key in nights.keys]
        first = next(row for row in rows if row)
        columns = [
            np.array([np.nan if row is None or row[column] is None else row[column] for row in rows], float)
            for column in ("value", "low", "high", "temperature", "common")
        ]
        yield Series(nights, first["kind"], name, first["joint"], first["unit"], *columns)
