"""Long recordings are cut into excerpts."""

from collections.abc import Callable

import numpy as np

from ident.data.excerpts import COUNT, MAX_DURATION, excerpts
from recordings.recording import Recording


def test_short_recordings_are_used_completely(make: Callable[..., Recording]) -> None:
    recording = make(cycles=2, rate=100.0)
    (excerpt,) = excerpts(recording)
    assert excerpt.recording is recording
    assert excerpt.start == 0


def test_long_recordings_are_cut_into_excerpts_of_whole_cycles(make: Callable[..., Recording]) -> None:
    recording = make(cycles=60, rate=50.0)
    sections = excerpts(recording)
    assert len(sections) == COUNT
    for excerpt in sections:
        excerpt_recording = excerpt.recording
        assert excerpt_recording.time[0] == 0
        assert len(np.unique(excerpt_recording.repeat[excerpt_recording.repeat >= 0])) >= 2
        first = int(np.searchsorted(recording.time, excerpt.start))
        np.testing.assert_array_equal(
            excerpt_recording.position, recording.position[first : first + len(excerpt_recording.time)]
        )
    assert sections[0].start < 20
    assert sections[-1].start > recording.time[-1] - 60
    assert sum(excerpt.recording.time[-1] for excerpt in sections) < 2 * MAX_DURATION
