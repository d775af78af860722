"""The changes of a whole fleet: at most one in a hundred of those that are reported is expected to be chance.

Every series of every robot is a hypothesis with an e-value. The e-BH procedure (Wang and Ramdas, False discovery rate
control with e-values, 2022) chooses among them; it allows any dependence between series, and there is much: one
effect changes many parameters. Changes of one robot at the same time are one event. Beside an event the nights before
and after it are searched again, with smaller weights.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ident.basics.statistics import NORMAL
from ident.fleet.change_point import MIN_BEFORE, MIN_GROWING, MIN_SUDDEN, Change, change
from ident.fleet.common_course import with_common_course
from ident.fleet.series import Nights, Series
from recordings.recording import Floats, Ints

FALSE_DISCOVERY_RATE = 0.01
_DEPTH_WEIGHTS = (0.5, 0.125, 0.03125)
"""Weight of a hypothesis on all nights, on those before or after an event, and so on; with one, two and four parts
they add up to less than 1."""


@dataclass(frozen=True, eq=False)
class SeriesChange:
    """A series in which a change was found."""

    series: Series
    """With all nights."""
    change: Change
    """With the numbers of the robot's nights."""
    beyond_intervals: bool
    """Whether the change exceeds the intervals of the nights before and after."""


@dataclass(frozen=True, eq=False)
class Event:
    """What happened to one robot at one time."""

    nights: Nights
    changes: tuple[SeriesChange, ...]
    """The strongest first; it dates the event."""
    segment: tuple[int, int]
    """First night of those that were compared, and the one after the last."""
    end: int
    """The night until before which nights since the event are to be searched for another one."""

    @property
    def change(self) -> Change:
        """The strongest one."""
        return self.changes[0].change


@dataclass(frozen=True, eq=False)
class _Hypothesis:
    series: Series
    first: int
    end: int
    depth: int
    change: Change | None
    """With the numbers of the robot's nights."""

    @property
    def log_e(self) -> float:
        return -np.inf if self.change is None else self.change.log_e + float(np.log(_DEPTH_WEIGHTS[self.depth]))


def events(series: Sequence[Series]) -> list[Event]:
    """The events of a fleet, robot by robot in the order of time."""
    series = with_common_course(series)
    tested = [_test(each, 0, len(each.nights.day), 0) for each in series]
    count, searched = len(tested), set[tuple[str, int, int]]()
    result: list[Event] = []
    while True:
        rejected = [tested[i] for i in e_bh([hypothesis.log_e for hypothesis in tested], count)]
        parts = {(hypothesis.series.nights.robot, hypothesis.first, hypothesis.end) for hypothesis in rejected}
        new = [_event(part, rejected) for part in sorted(parts - searched)]
        searched |= parts
        if not new:
            return sorted(result, key=lambda event: (event.nights.robot, event.change.index))
        for event, depth in (pair for pair in new if pair is not None):
            result.append(event)
            of_robot = [each for each in series if each.nights.robot == event.nights.robot]
            tested += [_test(each, *part, depth + 1) for part in _parts_beside(event, depth) for each in of_robot]


def e_bh(log_e: Sequence[float], count: int) -> list[int]:
    """Indices of the hypotheses rejected by e-BH: the k largest, if the k-th e-value is at least count / (k rate)."""
    if not len(log_e):
        return []
    order = np.argsort(-np.asarray(log_e), kind="stable")
    needed = np.log(count / FALSE_DISCOVERY_RATE) - np.log(np.arange(1, len(order) + 1))
    enough = np.flatnonzero(np.asarray(log_e)[order] >= needed)
    return sorted(order[: enough[-1] + 1].tolist()) if len(enough) else []


def _test(series: Series, first: int, end: int, depth: int) -> _Hypothesis:
    nights = np.flatnonzero(series.known[first:end]) + first
    result = change(watched(series, nights), series.nights.day[nights], nuisance(series, nights))
    if result is not None:
        index, begin, last = (int(nights[number]) for number in (result.index, result.first, result.last))
        result = replace(result, index=index, first=begin, last=last, seen=int(nights[result.seen - 1]) + 1)
    return _Hypothesis(series, first, end, depth, result)


def watched(series: Series, nights: Ints) -> Floats:
    """(n,) what is watched of a series in these `nights`: its value, or the logarithm of it."""
    value: Floats = series.value[nights]
    return np.log(value) if series.logarithmic else value


def nuisance(series: Series, nights: Ints) -> Floats:
    """(n, k) what may explain a difference between `nights`: motion, temperature, or what the whole fleet does."""
    motion, temperature = series.nights.motion[nights], series.temperature[nights]
    columns = [(motion == number).astype(float) for number in np.unique(motion)]
    measured = np.isfinite(temperature)
    if measured.any():
        columns.append(np.where(measured, temperature - temperature[measured].mean(), 0.0))
    if measured.any() and not measured.all():
        columns.append(measured.astype(float))
    if series.common is not None:
        columns.append(series.common[nights])
    return np.column_stack(columns)


def _event(part: tuple[str, int, int], rejected: Sequence[_Hypothesis]) -> tuple[Event, int] | None:
    """The event of one robot between two nights, and its depth; None if it does not last, or is within intervals."""
    of_part = [each for each in rejected if (each.series.nights.robot, each.first, each.end) == part]
    changes = [
        SeriesChange(each.series, each.change, _beyond_intervals(each.series, each.change, part[1]))
        for each in sorted(of_part, key=lambda hypothesis: -hypothesis.log_e)
        if each.change is not None and _lasts(each.change)
    ]
    changes = [each for each in changes if each.beyond_intervals]
    if not changes:
        return None
    # What changed later than this one is another event, which is found when the nights since then are searched.
    strongest = changes[0].change
    same = [each for each in changes if each.change.first <= strongest.last and strongest.first <= each.change.last]
    return Event(of_part[0].series.nights, tuple(same), (part[1], strongest.seen), part[2]), of_part[0].depth


def _lasts(shift: Change) -> bool:
    return shift.seen - shift.index >= (MIN_GROWING if shift.growing else MIN_SUDDEN)


def _beyond_intervals(series: Series, shift: Change, first: int) -> bool:
    """Whether a change is larger than the intervals of the mean of the nights before it, and of those since."""
    widths = []
    for nights in (slice(first, shift.index), slice(shift.index, shift.seen)):
        half = (series.high - series.low)[nights] / 2
        if series.logarithmic:
            half = half / series.value[nights]
        half = half[np.isfinite(half)]
        widths.append(float(np.sqrt(np.mean(half**2) / len(half))) if len(half) else 0.0)
    return abs(shift.size) > math.hypot(*widths) + NORMAL * shift.size_std


def _parts_beside(event: Event, depth: int) -> Iterator[tuple[int, int]]:
    """Nights before and after an event that are searched next; while something grows there is no new baseline."""
    parts = [(event.segment[0], event.change.index)]
    if not event.change.growing:
        parts.append((event.change.index, event.end))
    if depth + 1 < len(_DEPTH_WEIGHTS):
        yield from (part for part in parts if part[1] - part[0] >= MIN_BEFORE + MIN_SUDDEN)
