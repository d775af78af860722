"""What a diagnosis begins with: which recordings, at which cut-off."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from ident.diagnosis.diagnosis import MAX_TORQUE_LOSS, _band_share
from ident.identification.identify import refuse_overlap
from recordings.errors import BadInput
from recordings.recording import Recording


def test_a_low_pass_that_takes_ripple_away_takes_much_of_the_torque() -> None:
    time = np.arange(0.0, 5.0, 1e-3)[:, None]
    swaying = np.sin(2 * np.pi * time) + 0.3 * np.sign(np.sin(2 * np.pi * time))
    ripple = 0.3 * np.sin(2 * np.pi * 70.0 * time)
    assert _band_share(swaying, 1000.0, 23.0, 78.0) < MAX_TORQUE_LOSS / 2
    assert _band_share(swaying + ripple, 1000.0, 23.0, 78.0) > MAX_TORQUE_LOSS
    assert _band_share(swaying + ripple, 1000.0, 78.0, 78.0) == 0.0


def test_the_beginning_of_a_recording_is_no_other_recording(make: Callable[..., Recording]) -> None:
    whole, other = make(cycles=2), make("fig5b", cycles=2)
    half = len(whole.time) // 2
    part = replace(whole, time=whole.time[:half], position=whole.position[:half], voltage=whole.voltage[:half])
    refuse_overlap([whole, other])
    with pytest.raises(BadInput, match="begin with the same data"):
        refuse_overlap([other, whole, part])
