"""What the whole fleet does together: a season, where nobody measured temperatures.

Each recording is compared with the first one of the same robot and motion. What the other robots did by then is
written beside its rows once and stays so: what a night shows does not change in hindsight.
"""

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ident.fleet.recording_rows import Row
from ident.fleet.series import KINDS, day_of, motion_number
from recordings.recording import Floats

MIN_OTHERS = 4
"""Other robots whose median is the course of the fleet."""
SAME_NIGHT = 1.5
"""Recordings within so many days are of the same night [days]."""


@dataclass
class SeriesCourse:
    """What is remembered of one quantity of one robot."""

    first: dict[int, float] = field(default_factory=dict)
    """Its first value by the number of the motion."""
    days: list[float] = field(default_factory=list)
    """Start of its recordings; of those before this run only the last [days since 1970]."""
    deviations: list[float] = field(default_factory=list)
    """Relative to the first value."""


@dataclass
class RobotCourse:
    """What is remembered of one robot."""

    motions: list[list[float]] = field(default_factory=list)
    """Features of its motions by their numbers."""
    series: dict[str, SeriesCourse] = field(default_factory=dict)


Course = dict[str, RobotCourse]
"""By the name of the robot."""


def compare(course: Course, rows: Sequence[Row]) -> None:
    """Write beside new `rows` what the other robots did by then, where no temperature is known.

    rows: those that the `course` remembers since it last forgot some.
    """
    by_name: dict[str, list[Row]] = defaultdict(list)
    for row in rows:
        if _is_value(row) and row["temperature"] is None:
            by_name[row["name"]].append(row)
    for name, of_name in by_name.items():
        _compare({robot: each.series[name] for robot, each in course.items() if name in each.series}, of_name)


def remember(course: Course, rows: Sequence[Row]) -> None:
    """Add `rows` to the `course`, and write the number of their motion beside them; twice is as good as once."""
    for row in rows:
        if row["status"] == "done":
            row["motion_number"] = _remember(course, row)


def forget(course: Course) -> None:
    """Keep of each series what the next nights are compared with."""
    for robot in course.values():
        for series in robot.series.values():
            last = int(np.argmax(series.days))
            series.days, series.deviations = [series.days[last]], [series.deviations[last]]


def _remember(course: Course, row: Row) -> int:
    robot = course.setdefault(row["robot"], RobotCourse())
    motion = motion_number(row["motion"], robot.motions)
    if _is_value(row):
        series = robot.series.setdefault(row["name"], SeriesCourse())
        first = series.first.setdefault(motion, row["value"])
        series.days.append(day_of(row["start"]))
        series.deviations.append((row["value"] - first) / (abs(first) or 1.0))
    return motion


def _is_value(row: Row) -> bool:
    return row["kind"] in KINDS and math.isfinite(row["value"])


def _compare(of_robot: dict[str, SeriesCourse], rows: Sequence[Row]) -> None:
    """Write beside each of the `rows` the median of the others' deviations at that time, if there are enough."""
    days, place = np.unique([day_of(row["start"]) for row in rows], return_inverse=True)
    deviations = {robot: _latest(series, days) for robot, series in of_robot.items()}
    everyone = np.array(list(deviations.values()))
    number = {robot: index for index, robot in enumerate(deviations)}
    for row, night in zip(rows, place.tolist(), strict=True):
        others = np.delete(everyone[:, night], number[row["robot"]])
        others = others[np.isfinite(others)]
        row["common"] = float(np.median(others)) if len(others) >= MIN_OTHERS else None


def _latest(series: SeriesCourse, days: Floats) -> Floats:
    """(n,) deviation of the last recording until each of the `days`; NaN if there was none in that night."""
    order = np.argsort(series.days, kind="stable")
    known, deviations = np.array(series.days)[order], np.array(series.deviations)[order]
    last = np.searchsorted(known, days, side="right") - 1
    near = (last >= 0) & (days - known[last] <= SAME_NIGHT)
    return np.where(near, deviations[last], np.nan)
