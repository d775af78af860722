"""Score alarms against the sealed truth of a fleet."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

import ident
from benchmarks.fleet import record

NEAR_NIGHTS = 2
"""Recordings by which a sudden event may be dated wrong."""
TIMES_SMALLEST = 2
"""A growing event is to be dated before it is so many times as large as one night's interval separates from zero."""
SHORT_LIST = 4

Smallest = Callable[[dict[str, Any]], float]
"""Of an event: the share of its final size that the interval of one night separates from zero."""


@dataclass(frozen=True)
class Score:
    """How one hidden event was reported."""

    event: dict[str, Any]
    raised: bool
    named: bool
    """Whether the effect, or its short list, is right."""
    joint: bool
    nights_off: int | None
    """Nights between the true date and the reported one."""
    dated: bool
    """Whether that is near enough."""

    @property
    def right(self) -> bool:
        """Whether all of it is right."""
        return self.raised and self.named and self.joint and self.dated


def score(
    truth: dict[str, Any], alarms: Sequence[dict[str, Any]], smallest: Smallest
) -> tuple[list[Score], list[dict[str, Any]]]:
    """The score of every event of the `truth`, and the alarms that belong to none: false ones."""
    scores, used = [], []
    for event in truth["events"]:
        of_robot = [alarm for alarm in alarms if alarm["robot"] == event["robot"]]
        closest = min(of_robot, key=lambda alarm: abs(_nights(alarm["since"], event["since"])), default=None)
        scores.append(_scored(event, closest, _latest(event, truth["nights"], smallest)))
        used.append(closest)
    return scores, [alarm for alarm in alarms if not any(alarm is other for other in used)]


def smallest_in(recordings: Path) -> Smallest:
    """`Smallest` by the last recording of the robot in this folder that can be used, fitted with the effect."""

    def smallest(event: dict[str, Any]) -> float:
        for path in sorted((recordings / event["robot"]).glob("*.mcap"))[::-1]:
            try:
                model = ident.fit([path], method="wls", effects=[f"{event['effect']}:{event['joint']}"])
            except ident.BadInput:
                continue
            night = (date.fromisoformat(path.stem) - record.FIRST_NIGHT).days
            share = (night - event["night"] + 1) / (event["nights"] - event["night"])
            relative = [
                (entry.ci95[1] - entry.ci95[0]) / 2 / abs(entry.value)
                for entry in model.file.parameters
                if entry.ci95 and entry.name.startswith(f"{event['effect']}.")
            ]
            return float(share * min(relative, default=0.0))
        return 0.0

    return smallest


def _latest(event: dict[str, Any], nights: int, smallest: Smallest) -> int:
    """Nights by which the date may be too late."""
    if not event["growing"]:
        return NEAR_NIGHTS
    share = TIMES_SMALLEST * smallest({**event, "nights": nights})
    # The share of the final size is (nights since then + 1) / (nights - night).
    return max(int(share * (nights - event["night"])) - 1, 0)


def _scored(event: dict[str, Any], alarm: dict[str, Any] | None, latest: int) -> Score:
    if alarm is None:
        return Score(event, False, False, False, None, False)
    off = _nights(alarm["since"], event["since"])
    dated = -NEAR_NIGHTS <= off <= latest
    joint = not set(event.get("joints", [event["joint"]])).isdisjoint(alarm["joints"])
    return Score(event, True, _named(event, alarm), joint, off, dated)


def _named(event: dict[str, Any], alarm: dict[str, Any]) -> bool:
    """Whether the effect or its short list is right; for one outside of the library: a variable, and no name."""
    if event.get("outside"):
        return alarm["effect"] is None and not set(event["outside"]).isdisjoint(alarm["depends_on"])
    return event["effect"] in (alarm["effect"], *alarm["confusable_with"][:SHORT_LIST])


def _nights(later: str, earlier: str) -> int:
    return (date.fromisoformat(later) - date.fromisoformat(earlier)).days
