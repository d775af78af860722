"""Long recordings are looked at in parts."""

from collections.abc import Callable

import numpy as np

from ident.data.excerpts import MAX_DURATION, COUNT, excerpts
from recordings.recording import Recording


def test_short_ones_are_used_whole(make: Callable[..., Recording]) -> None:
    recording = make(cycles=2, rate=100.0)
    (only,) = excerpts(recording)
    assert only.recording is recording
    assert only.start == 0


def test_long_ones_are_cut_into_whole_cycles_from_beginning_to_end(make: Callable[..., Recording]) -> None:
    recording = make(cycles=60, rate=50.0)
    parts = excerpts(recording)
    assert len(parts) == COUNT
    for part in parts:
        own = part.recording
        assert own.time[0] == 0
        assert len(np.unique(own.repeat[own.repeat >= 0])) >= 2
        first = int(np.searchsorted(recording.time, part.start))
        np.testing.assert_array_equal(own.position, recording.position[first : first + len(own.time)])
    assert parts[0].start < 20
    assert parts[-1].start > recording.time[-1] - 60
    assert sum(part.recording.time[-1] for part in parts) < 2 * MAX_DURATION
