from itertools import pairwise

import numpy as np
import pytest

from ident.data.prepared_recording import PreparedRecording
from ident.residuals.windows import DURATION, worst_windows
from recordings.recording import Floats
from tests.ident.residuals.conftest import Planted


def test_a_burst_is_located(planted: Planted, prepared: PreparedRecording, noise: Floats) -> None:
    burst = (prepared.time >= 9.0) & (prepared.time < 9.0 + DURATION)
    first, second = worst_windows([planted(noise + 1.0 * burst[:, None] * [0, 1, 0])], 2)
    assert (first.joint, first.recording) == (2, "made.mcap")
    assert first.start == pytest.approx(9.0, abs=0.05)
    assert first.end - first.start == pytest.approx(DURATION, abs=0.01)
    assert first.mean == pytest.approx(1.0, abs=0.1)
    assert first.cycle == prepared.repeat[np.searchsorted(prepared.time, 9.1)] + 1
    assert first.times_overall > 2 * second.times_overall


def test_the_same_part_of_the_motion_is_reported_once(
    planted: Planted, prepared: PreparedRecording, noise: Floats
) -> None:
    at_phases = (abs(prepared.phase - 1.0) < 0.1) | (abs(prepared.phase - 2.5) < 0.1)
    windows = worst_windows([planted(noise + 1.0 * at_phases[:, None] * [1, 0, 0])], 3)
    named = sorted(
        float(prepared.phase[np.searchsorted(prepared.time, window.start + DURATION / 2)]) for window in windows[:2]
    )
    assert named == pytest.approx([1.0, 2.5], abs=0.15)
    assert windows[2].times_overall < windows[1].times_overall / 2


def test_windows_do_not_overlap(planted: Planted, noise: Floats) -> None:
    windows = sorted(
        (window for window in worst_windows([planted(noise)], 12) if window.joint == 1),
        key=lambda window: window.start,
    )
    assert len(windows) > 1
    assert all(first.end <= second.start + 1e-9 for first, second in pairwise(windows))


def test_a_zero_residual_has_no_windows(planted: Planted, noise: Floats) -> None:
    assert worst_windows([planted(0 * noise)], 3) == ()
