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

    def between(self, first: int, end: int) -> "Nights":
        """Those from `first` until before `end`."""
        part = slice(first, end)
        return Nights(self.robot, self.keys[part], self.paths[part], self.day[part], self.motion[part])


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
    common: Floats | None = None
    """(n,) what the same quantity of the other robots did, relative; None: too few robots, or not needed."""

    @property
    def known(self) -> Bools:
        """(n,) nights in which it was measured."""
        return np.isfinite(self.value)

    @property
    def logarithmic(self) -> bool:
        """Whether it is watched by its logarithm."""
        value = self.value[self.known]
        half = (self.high - self.low)[self.known] / 2
        return bool(len(value) and (value > 0).all() and np.median(half / value) < _LARGEST_HALF_WIDTH)


def moment(day: float) -> datetime:
    """The time (UTC) so many days after 1970, without a zone."""
    return datetime.fromtimestamp(day * _DAY, UTC).replace(tzinfo=None)


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
        np.array([row["start"].timestamp() / _DAY for row in recordings]),
        motions([row["motion"] for row in recordings]),
    )


def motions(features: Sequence[Sequence[float]]) -> Ints:
    """(n,) number of each recording's motion by its `features`; the same motion has the same number."""
    known: list[Floats] = []
    numbers = []
    for row in features:
        feature = np.array(row)
        # Angles are compared with how far the joints move, periods with the period.
        scale = np.r_[max(feature[0], 1e-9), np.full(len(feature) - 1, max(feature[1:].max(initial=0.0), 1e-9))]
        same = (
            number
            for number, other in enumerate(known)
            if len(other) == len(feature) and (np.abs(other - feature) < SAME_MOTION * scale).all()
        )
        number = next(same, len(known))
        if number == len(known):
            known.append(feature)
        numbers.append(number)
    return np.array(numbers, np.int64)


def _series(nights: Nights, values: dict[str, dict[str, Row]]) -> Iterator[Series]:
    names = sorted({name for key in nights.keys for name in values[key]})
    for name in names:
        rows = [values[key].get(name) for key in nights.keys]
        first = next(row for row in rows if row)
        columns = [
            np.array([np.nan if row is None or row[column] is None else row[column] for row in rows], float)
            for column in ("value", "low", "high", "temperature")
        ]
        yield Series(nights, first["kind"], name, first["joint"], first["unit"], *columns)
