"""Checks that recordings can be used together."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from ident.data.compatibility import check_no_overlap
from recordings.errors import BadInput
from recordings.recording import Recording


def test_a_recording_that_is_the_beginning_of_another_is_refused(make: Callable[..., Recording]) -> None:
    whole, different = make(cycles=2), make("fig5b", cycles=2)
    half = len(whole.time) // 2
    beginning = replace(whole, time=whole.time[:half], position=whole.position[:half], voltage=whole.voltage[:half])
    check_no_overlap([whole, different])
    with pytest.raises(BadInput, match="begin with the same data"):
        check_no_overlap([different, whole, beginning])
