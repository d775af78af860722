"""Excerpts of a long recording, spread from its beginning to its end."""

from dataclasses import dataclass, replace

import numpy as np

from ident.basics import slicing
from recordings.recording import Recording

MAX_DURATION = 150.0
"""Recordings up to this duration are used completely [s]."""
LENGTH = 12.5
"""Length of each excerpt of a longer one, without its run-in [s]. All together are several times as long as the
recordings of 20 s by which the accuracy of a diagnosis is measured."""
COUNT = 6
"""Number of excerpts, spread from beginning to end so that slow changes remain visible."""
_MARGIN = 1.0
"""Run-in of the filters, kept on both sides [s]."""


@dataclass(frozen=True, eq=False)
class Excerpt:
    """A section of a recording, as a recording."""

    recording: Recording
    start: float
    """Start time on the clock of the whole recording [s]."""
    end: float | None = None
    """End of the whole recording on that clock [s]; None: this is the whole."""


def excerpts(recording: Recording) -> list[Excerpt]:
    """Return `recording` itself if it is short, else COUNT evenly spaced excerpts, of whole cycles if possible."""
    time = recording.time
    if time[-1] - time[0] <= MAX_DURATION:
        return [Excerpt(recording, 0.0)]
    cycles = np.unique(recording.repeat[recording.repeat >= 0])
    cycles_each = max(2, round(LENGTH / recording.run.period)) if len(cycles) else 0
    if len(cycles) >= COUNT * cycles_each > 0:
        first = np.linspace(0, len(cycles) - cycles_each, COUNT).round().astype(int)
        spans = [_span(recording, cycles[start], cycles[start + cycles_each - 1]) for start in first]
    else:
        # Spread over the rows: in a gap of an hour there are none to cut.
        last = np.searchsorted(time, time[-1] - LENGTH)
        spans = [(start, start + LENGTH) for start in time[np.linspace(0, last, COUNT).round().astype(int)]]
    return [_cut(recording, start - _MARGIN, end + _MARGIN) for start, end in spans]


def _span(recording: Recording, first: int, last: int) -> tuple[float, float]:
    """Start and end time of the cycles `first` to `last` [s]."""
    inside = recording.time[(recording.repeat >= first) & (recording.repeat <= last)]
    return float(inside[0]), float(inside[-1])


def _cut(recording: Recording, start: float, end: float) -> Excerpt:
    selected = (recording.time >= start) & (recording.time <= end)
    cut = slicing.along_time(recording, selected)
    start = float(cut.time[0])
    return Excerpt(replace(cut, time=cut.time - start), start, float(recording.time[-1]))
