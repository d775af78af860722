"""A warning if the model fails where the test motion leaves the training range."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.document.warnings import extrapolation_warnings
from recordings.rig import simulated_rig

_ROWS = 2000
_TIME = np.arange(_ROWS) / 500.0


def _warnings(
    reach: float, large_error: Any, other_motion: bool = True, still: int | None = None, floor: float = 1.0
) -> list[str]:
    """Warnings for a test motion with `reach` times the training torque of joint 2.

    large_error: rows with errors of 5 noise floors, by the torque of joint 2; still: joint without training rows.
    """
    recording = SimpleNamespace(rig=simulated_rig())
    wave = np.stack([np.sin(2 * np.pi * (0.5 + 0.1 * joint) * _TIME) for joint in range(3)], axis=1)
    torques = [wave, wave * [1.0, reach, 1.0]]
    motions = [
        SimpleNamespace(velocity=np.roll(torque, 100, axis=0), position=np.roll(wave, 50, axis=0))
        for torque in torques
    ]
    recordings = tuple(
        SimpleNamespace(recording=recording, torque=torque, motion=motion, time=_TIME, rate=500.0, bandwidth=50.0)
        for torque, motion in zip(torques, motions, strict=True)
    )
    rows = np.ones((_ROWS, 3), bool)
    train = rows.copy()
    if still is not None:
        train[:, still] = False
    residual = np.random.default_rng(0).normal(size=(_ROWS, 3))
    failed = residual.copy()
    failed[large_error(torques[1][:, 1]), 1] *= 5.0
    split: Any = SimpleNamespace(
        recordings=recordings, other_motion=other_motion, train=(train, ~rows), test=(~rows, rows), train_indices=(0,)
    )
    noise_floor = SimpleNamespace(rms=np.full(3, floor), limit=np.full(3, 1.1 * floor))
    model: Any = SimpleNamespace(residuals=(residual, failed), noise_floor=noise_floor)
    return list(extrapolation_warnings(split, model))


def test_warning_if_the_model_fails_only_outside_the_training_range() -> None:
    (warning,) = _warnings(1.5, lambda torque: np.abs(torque) > 1.05)
    assert warning.startswith("Joint 2: ")
    assert "its torque is outside of the -1 to 1 N m of the training data" in warning


@pytest.mark.parametrize(
    ("reach", "large_error"),
    [
        (1.5, lambda torque: np.abs(torque) < 0.5),  # fails inside the range
        (1.5, lambda torque: torque > 9.0),  # does not fail
        (1.0, lambda torque: torque > 0.8),  # nothing is outside
        (20.0, lambda torque: torque < 9.0),  # nearly all is outside
        (1.5, lambda torque: torque < 9.0),  # fails everywhere, and as much outside as inside
    ],
)
def test_no_warning_if_the_range_does_not_explain_the_error(reach: float, large_error: Any) -> None:
    assert _warnings(reach, large_error) == []


def test_no_warning_for_phase_segments_of_the_same_motion() -> None:
    assert _warnings(1.5, lambda torque: np.abs(torque) > 1.05, other_motion=False) == []


def test_joint_without_training_rows_has_no_range() -> None:
    assert _warnings(1.5, lambda torque: np.abs(torque) > 1.05, still=1) == []


def test_zero_noise_floor_is_accepted() -> None:
    assert _warnings(1.5, lambda torque: torque > 9.0, floor=0.0) == []
