"""What the series of a robot have shown so far, night by night: all that the next night needs of those before.

Evidence since night 0 goes on for ever; beside an event it is gathered anew since the night of the event, and since a
repair. What it was when some night began is kept in `records`, so that nights before an event need no second look.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from ident.basics.statistics import NORMAL
from ident.fleet.series import KINDS, Nights, Series, logarithmic
from ident.fleet.thinned_series import ThinnedSeries
from ident.sequential.change_point import LONGEST, MIN_BEFORE, Change, ChangeProcess

METHOD = 1
"""Version of the evidence; raised whenever the same rows show something else."""
_LEAST = 0.1
"""Share of its least value in the baseline, to which a quantity that is watched by its logarithm may fall."""


@dataclass(frozen=True)
class Record:
    """More evidence in a series than ever before."""

    change: Change
    """With the numbers of the robot's nights."""
    beyond_intervals: bool
    """Whether it is larger than the intervals of the mean of the nights before it, and of those since."""


@dataclass(frozen=True)
class Night:
    """One quantity in one night."""

    number: int
    """Of the robot's nights, from 0."""
    day: float
    value: float
    half: float | None
    """Half of its 95 % interval; None: there is none."""
    nuisance: list[float]
    """What may explain a difference: temperature, what the whole fleet does, motion."""


@dataclass
class SeriesEvidence:
    """Evidence of a change in one series since some night."""

    joint: int | None
    """From 1; None: of the whole robot."""
    baseline: list[Night] = field(default_factory=list)
    """The first nights, until they say on which scale the quantity is watched."""
    least: float | None = None
    """What is less counts as this where the logarithm is watched; None: the value itself is."""
    process: ChangeProcess = field(default_factory=ChangeProcess)
    recent: list[tuple[int, float | None]] = field(default_factory=list)
    """Number and squared half interval of the last nights."""
    before: tuple[float, int] = (0.0, 0)
    """Sum of the squared half intervals of all nights before those, and their number."""
    records: list[Record] = field(default_factory=list)

    def observe(self, night: Night) -> None:
        """Take the next night."""
        if self.process.count:
            return self._take(night)
        self.baseline.append(night)
        if len(self.baseline) == MIN_BEFORE:
            value = np.array([each.value for each in self.baseline])
            half = np.array([np.nan if each.half is None else each.half for each in self.baseline])
            self.least = _LEAST * float(value.min()) if logarithmic(value, half) else None
            for each in self.baseline:
                self._take(each)
            self.baseline = []
        return None

    def until(self, night: int) -> Record | None:
        """The most that was shown before a `night`; None: nothing."""
        return next((record for record in reversed(self.records) if record.change.seen <= night), None)

    def _take(self, night: Night) -> None:
        value, half = night.value, night.half
        if self.least is not None:
            least = max(value, self.least)
            value, half = math.log(least), None if half is None else half / least
        self.recent.append((night.number, None if half is None else half**2))
        if len(self.recent) > LONGEST + 1:
            square = self.recent.pop(0)[1]
            self.before = _sum([square], self.before)
        change = self.process.observe(value, night.day, night.nuisance)
        if change is not None and change.log_e > 0:
            self._keep(change)

    def _keep(self, change: Change) -> None:
        oldest = self.process.count - len(self.recent)
        index, first, last = (self.recent[night - oldest][0] for night in (change.index, change.first, change.last))
        squares = [square for _, square in self.recent]
        sides = _sum(squares[: change.index - oldest], self.before), _sum(squares[change.index - oldest :])
        widths = (math.sqrt(total) / count for total, count in sides if count)
        beyond = abs(change.size) > math.hypot(*widths) + NORMAL * change.size_std
        numbered = replace(change, index=index, first=first, last=last, seen=self.recent[-1][0] + 1)
        self.records.append(Record(numbered, beyond))


@dataclass
class RobotEvidence:
    """Evidence in all series of one robot."""

    robot: str
    method: int = METHOD
    days: list[float] = field(default_factory=list)
    """Start of each night [days since 1970]."""
    since: dict[int, dict[str, SeriesEvidence]] = field(default_factory=lambda: {0: {}})
    """By the first night of the evidence, and the name of the series."""
    trends: dict[str, ThinnedSeries] = field(default_factory=dict)
    """By the name of the series."""

    def go_on(self, nights: Nights, series: Sequence[Series]) -> None:
        """Take `series` over the next `nights`."""
        for evidence in self.since.values():
            _observe(evidence, series, len(self.days))
        self.days += nights.day.tolist()
        for each in series:
            trend = self.trends.setdefault(each.name, ThinnedSeries(each.kind, each.joint, each.unit))
            half = np.nan_to_num((each.high - each.low) / 2)
            for night in np.flatnonzero(each.known).tolist():
                motion, day = int(nights.motion[night]), float(nights.day[night])
                trend.add(motion, day, float(each.value[night]), float(half[night]))

    def begin(self, first: int, series: Sequence[Series]) -> None:
        """Gather evidence anew since the night `first`. series: over all nights."""
        _observe(self.since.setdefault(first, {}), series, 0, first)

    def parts(self, repaired: Sequence[float]) -> list[tuple[int, int]]:
        """Nights between repairs: the first, and the one after the last. repaired: days of the repairs."""
        begin = np.searchsorted(self.days, repaired).tolist()
        return list(pairwise(sorted({0, *begin, len(self.days)})))


def _observe(evidence: dict[str, SeriesEvidence], series: Sequence[Series], count: int, first: int = 0) -> None:
    """Add nights to the `evidence`. count: number of nights before those of the `series`; first: the first used."""
    for each in series:
        for night in np.flatnonzero(each.known).tolist() if each.kind in KINDS else ():
            if count + night >= first:
                of_name = evidence.setdefault(each.name, SeriesEvidence(each.joint))
                of_name.observe(_night(each, night, count + night))


def _night(series: Series, night: int, number: int) -> Night:
    nuisance = [*_measured(series.temperature[night]), *_measured(series.common[night])]
    motion = [*[0.0] * int(series.nights.motion[night]), 1.0]
    half = float(series.high[night] - series.low[night]) / 2
    value, day = float(series.value[night]), float(series.nights.day[night])
    return Night(number, day, value, half if math.isfinite(half) else None, [*nuisance, *motion])


def _measured(value: float) -> tuple[float, float]:
    """The `value` and 1; 0 and 0 if it is not known."""
    return (float(value), 1.0) if math.isfinite(value) else (0.0, 0.0)


def _sum(squares: Sequence[float | None], before: tuple[float, int] = (0.0, 0)) -> tuple[float, int]:
    known = [square for square in squares if square is not None]
    return before[0] + sum(known), before[1] + len(known)
