"""The changes of a whole fleet: at most one in a hundred of those that are reported is expected to be chance.

Every series of every robot is a hypothesis with an e-value. The e-BH procedure (Wang and Ramdas, False discovery rate
control with e-values, 2022) chooses among them; it allows any dependence between series, and there is much: one
effect changes many parameters. Changes of one robot at the same time are one event. Beside an event the nights before
and after it are searched again, with smaller weights.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ident.fleet.evidence import Record, RobotEvidence
from ident.fleet.series import Series
from ident.sequential.change_point import MIN_BEFORE, MIN_GROWING, MIN_SUDDEN, Change

FALSE_DISCOVERY_RATE = 0.01
_DEPTH_WEIGHTS = (0.5, 0.125, 0.03125)
"""Weight of a hypothesis on all nights, on those before or after an event, and so on; with one, two and four parts
they add up to less than 1."""


@dataclass(frozen=True)
class SeriesChange:
    """A series in which a change was found."""

    name: str
    joint: int | None
    """From 1; None: of the whole robot."""
    change: Change
    """With the numbers of the robot's nights."""


@dataclass(frozen=True)
class Event:
    """What happened to one robot at one time."""

    robot: str
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


Part = tuple[str, int, int]
"""Robot, first of its nights, and the one after the last."""


@dataclass(frozen=True)
class _Hypothesis:
    part: Part
    depth: int
    name: str
    joint: int | None
    record: Record | None

    @property
    def log_e(self) -> float:
        if self.record is None:
            return -np.inf
        return self.record.change.log_e + float(np.log(_DEPTH_WEIGHTS[self.depth]))


def events(
    fleet: Mapping[str, RobotEvidence],
    repaired: Mapping[str, Sequence[float]],
    series: Callable[[str], Sequence[Series]],
) -> list[Event]:
    """The events of a `fleet`, robot by robot in the order of time. Evidence that is needed no more is removed.

    repaired: days of the repairs of a robot, from which on it has a new baseline. series: all those of a robot, read
    where evidence is gathered anew.
    """
    tested, searched, result = list[_Hypothesis](), set[Part](), list[Event]()

    def test(part: Part, depth: int) -> None:
        robot, first, end = part
        if first not in fleet[robot].since:
            fleet[robot].begin(first, series(robot))
        for name, evidence in fleet[robot].since[first].items():
            tested.append(_Hypothesis(part, depth, name, evidence.joint, evidence.until(end)))

    baselines = [(name, *nights) for name in sorted(fleet) for nights in fleet[name].parts(repaired.get(name, ()))]
    for part in baselines:
        test(part, 0)
    count = len(tested)
    while True:
        rejected = [tested[i] for i in e_bh([hypothesis.log_e for hypothesis in tested], count)]
        new = sorted({hypothesis.part for hypothesis in rejected} - searched)
        searched |= set(new)
        if not new:
            break
        for event, depth in filter(None, (_event(part, rejected) for part in new)):
            result.append(event)
            for nights in _parts_beside(event, depth):
                test((event.robot, *nights), depth + 1)
    for name, robot in fleet.items():
        used = {0, *(hypothesis.part[1] for hypothesis in tested if hypothesis.part[0] == name)}
        robot.since = {first: evidence for first, evidence in robot.since.items() if first in used}
    return sorted(result, key=lambda event: (event.robot, event.change.index))


def e_bh(log_e: Sequence[float], count: int) -> list[int]:
    """Indices of the hypotheses rejected by e-BH: the k largest, if the k-th e-value is at least count / (k rate)."""
    if not len(log_e):
        return []
    order = np.argsort(-np.asarray(log_e), kind="stable")
    needed = np.log(count / FALSE_DISCOVERY_RATE) - np.log(np.arange(1, len(order) + 1))
    enough = np.flatnonzero(np.asarray(log_e)[order] >= needed)
    return sorted(order[: enough[-1] + 1].tolist()) if len(enough) else []


def _event(part: Part, rejected: Sequence[_Hypothesis]) -> tuple[Event, int] | None:
    """The event of one robot between two nights, and its depth; None if it does not last, or is within intervals."""
    robot, first, end = part
    of_part = [each for each in rejected if each.part == part]
    changes = [
        SeriesChange(each.name, each.joint, each.record.change)
        for each in sorted(of_part, key=lambda hypothesis: -hypothesis.log_e)
        if each.record is not None and _lasts(each.record.change) and each.record.beyond_intervals
    ]
    if not changes:
        return None
    # What changed later than this one is another event, which is found when the nights since then are searched.
    strongest = changes[0].change
    same = [each for each in changes if each.change.first <= strongest.last and strongest.first <= each.change.last]
    return Event(robot, tuple(same), (first, strongest.seen), end), of_part[0].depth


def _lasts(shift: Change) -> bool:
    return shift.seen - shift.index >= (MIN_GROWING if shift.growing else MIN_SUDDEN)


def _parts_beside(event: Event, depth: int) -> Iterator[tuple[int, int]]:
    """Nights before and after an event that are searched next; while something grows there is no new baseline."""
    parts = [(event.segment[0], event.change.index)]
    if not event.change.growing:
        parts.append((event.change.index, event.end))
    if depth + 1 < len(_DEPTH_WEIGHTS):
        yield from (part for part in parts if part[1] - part[0] >= MIN_BEFORE + MIN_SUDDEN)
