"""Split recordings into training rows and test rows."""

from collections.abc import Sequence

import numpy as np

from ident.data import noise
from ident.data.prepared_recording import PreparedRecording
from ident.data.quantization import with_encoder_errors
from ident.data.recording_facts import MOVING
from ident.diagnosis.split.split_data import MAX_STANDSTILL, SplitData, row_count
from ident.estimation.predicted_torque import TorquePredictor, cache_size
from ident.threads import in_threads
from recordings.errors import BadInput
from recordings.recording import Bools, Floats

SEGMENTS = 15
"""Number of segments of a cycle if there is no other recording to validate on; every third one is a test segment."""
_MIN_SEGMENT = 5
"""Minimum length of a segment, in filter lengths."""
_DEVIATIONS = 3.0
"""Speeds within this many standard deviations of the quantization error are standstill."""


def split_recordings(train: Sequence[PreparedRecording], validate: Sequence[PreparedRecording]) -> SplitData:
    """Split recordings for training and recordings for validation; without the latter, split by phase segments."""
    recordings = [*train, *validate]
    standstill = in_threads(standstill_share, recordings)
    usable = [recording.usable for recording in recordings]
    moving = [rows & (share < MAX_STANDSTILL) for rows, share in zip(usable, standstill, strict=True)]
    all_rows, none = np.array([True]), np.array([False])
    parts = (
        [(all_rows, none)] * len(train) + [(none, all_rows)] * len(validate)
        if validate
        else [_phase_segments(recording) for recording in recordings]
    )
    train_rows, test_rows = _selected(moving, parts)
    train_all, test_all = _selected(usable, parts)
    _check_rows(recordings, train_rows, test_rows)
    weights = _weights(recordings, train_rows, standstill)
    size = cache_size(recordings)
    predictors = tuple(TorquePredictor(recording, size) for recording in recordings)
    return SplitData(
        predictors,
        train_rows,
        test_rows,
        tuple(np.where(rows, weight, 0.0) for rows, weight in zip(train_rows, weights, strict=True)),
        bool(validate),
        1 - int(row_count(moving).sum()) / max(int(row_count(usable).sum()), 1),
        train_all=train_all,
        test_all=test_all,
        row_weights=tuple(weights),
    )


def _check_rows(recordings: Sequence[PreparedRecording], train: Sequence[Bools], test: Sequence[Bools]) -> None:
    """Check that every joint moves in enough training rows and test rows, and that it is driven there.

    Raises:
        BadInput: a joint moves in too few rows to fit its parameters, or to judge them, or its torque is zero.
    """
    expected = recordings[0].regressor.shape[2]
    for rows, kind in ((train, "fitted"), (test, "held-out")):
        counts = row_count(rows)
        if counts.min() < expected:
            raise BadInput(
                f"at least {expected} {kind} samples of every joint in motion expected, {counts.min()} of joint "
                f"{counts.argmin() + 1} found; record a longer motion in which every joint moves"
            )
    driven = np.any(
        [((recording.torque != 0) & rows).any(axis=0) for recording, rows in zip(recordings, train, strict=True)],
        axis=0,
    )
    if not driven.all():
        raise BadInput(
            f"a torque that drives the motion expected, but that of joint {driven.argmin() + 1} is 0 wherever it "
            "moves; check what was recorded"
        )


def _selected(
    rows: Sequence[Bools], parts: Sequence[tuple[Bools, Bools]]
) -> tuple[tuple[Bools, ...], tuple[Bools, ...]]:
    """Those of the `rows` (m, dof) that are in the training part of each recording, and those in the test part."""
    train, test = zip(
        *[(each & part[0], each & part[1]) for each, part in zip(rows, parts, strict=True)], strict=True
    )
    return train, test


def _phase_segments(recording: PreparedRecording) -> tuple[Bools, Bools]:
    """(m, 1) training and test part: the same phase segments of all cycles, separated by the length of the filter.

    Whole cycles would leak: any function of phase that fits one cycle of a repeated motion fits the next.
    """
    phase = recording.phase if np.isfinite(recording.phase).any() else recording.time
    longest, reach = max(float(np.nanmax(phase)), 1 / recording.rate), 1.5 / recording.bandwidth
    segments = 3 * max(1, min(SEGMENTS // 3, int(longest / (3 * _MIN_SEGMENT * reach))))
    # Distance from the middle of the next test segment, in half segments; rows without a phase are in neither part.
    distance = np.abs(2 * (phase[:, None] * segments / longest - 1) % 6 - 3)
    guard = 2 * reach * segments / longest
    return distance > 1 + guard, distance < 1 - guard


def _weights(
    recordings: Sequence[PreparedRecording], train: Sequence[Bools], standstill: Sequence[Floats]
) -> list[Floats]:
    """1 / standard deviation of every row, from noise, a first fit's residual, and standstill."""
    indices = [i for i, rows in enumerate(train) if rows.any()]
    regressor = np.concatenate([recordings[i].regressor[train[i]] for i in indices])
    torque = np.concatenate([recordings[i].torque[train[i]] for i in indices])
    parameters = np.linalg.lstsq(regressor, torque, rcond=None)[0]
    residuals = [recording.torque - recording.regressor @ parameters for recording in recordings]
    noise_models = noise.estimate(recordings, residuals)
    return [
        1 / np.hypot(noise.residual_std(recording, residual, noise_models), still)
        for recording, residual, still in zip(recordings, residuals, standstill, strict=True)
    ]


def standstill_share(recording: PreparedRecording) -> Floats:
    """(m, dof) share of the instants behind a row at which a joint is too slow for its direction to be known.

    Dry friction may then be anywhere between its two levels. One threshold follows from the encoder steps; below the
    other, that is so in any machine.
    """
    motion, perturbed = recording.as_recorded.motion, with_encoder_errors(recording).as_recorded.motion
    threshold = _DEVIATIONS * np.nanstd(perturbed.velocity - motion.velocity, axis=0)
    speed = np.abs(motion.velocity)
    unsure, creeping = (
        np.clip(recording.condition(np.where(np.isfinite(speed), speed < limit, np.nan)), 0.0, 1.0)
        for limit in (threshold, MOVING * np.nanmax(speed, axis=0))
    )
    return np.maximum(unsure, np.rint(creeping))  # where it creeps most of the time; a reversal takes less
