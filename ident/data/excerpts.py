"""Parts of a long recording that tell as much about the model as the whole."""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from recordings.recording import Recording

MAX_DURATION = 150.0
"""Recordings up to this are used whole [s]; of longer ones about so much."""
COUNT = 6
"""From beginning to end, so that slow changes are seen."""
_MARGIN = 1.0
"""Kept on both sides for the filters [s]."""


@dataclass(frozen=True, eq=False)
class Excerpt:
    """A part of a recording as a recording of its own."""

    recording: Recording
    start: float
    """On the clock of the whole recording [s]."""


def excerpts(recording: Recording) -> list[Excerpt]:
    """`recording` itself, or PARTS of it at even distances, of whole cycles where there are enough."""
    time = recording.time
    if time[-1] - time[0] <= MAX_DURATION:
        return [Excerpt(recording, 0.0)]
    length = MAX_DURATION / COUNT
    cycles = np.unique(recording.repeat[recording.repeat >= 0])
    each = max(2, round(length / recording.run.period)) if len(cycles) else 0
    if len(cycles) >= COUNT * each > 0:
        first = np.linspace(0, len(cycles) - each, COUNT).round().astype(int)
        spans = [_span(recording, cycles[start], cycles[start + each - 1]) for start in first]
    else:
        spans = [(start, start + length) for start in np.linspace(time[0], time[-1] - length, COUNT)]
    return [_part(recording, start - _MARGIN, end + _MARGIN) for start, end in spans]


def _span(recording: Recording, first: int, last: int) -> tuple[float, float]:
    """Beginning and end of the cycles `first` to `last` [s]."""
    inside = recording.time[(recording.repeat >= first) & (recording.repeat <= last)]
    return float(inside[0]), float(inside[-1])


def _part(recording: Recording, start: float, end: float) -> Excerpt:
    chosen = (recording.time >= start) & (recording.time <= end)
    cut: dict[str, Any] = {
        name: value[chosen]
        for name in (field.name for field in fields(Recording))
        if isinstance(value := getattr(recording, name), np.ndarray)
    }
    first = float(cut["time"][0])
    extra = {name: value[chosen] for name, value in recording.extra.items()}
    return Excerpt(replace(recording, **{**cut, "time": cut["time"] - first}, extra=extra), first)
