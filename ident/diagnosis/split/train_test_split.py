"""Split recordings into training rows and test rows."""

from collections.abc import Sequence

import numpy as np

from ident.basics import filters
from ident.basics.threads import in_threads
from ident.data.prepared_recording import PreparedRecording
from ident.data.row_weights import moving_rows, row_weights, standstill_share
from ident.diagnosis.split.split_data import SplitData, row_count
from ident.estimation.possible_links import bound_to_bodies
from ident.estimation.predicted_torque import TorquePredictor, cache_size
from recordings.errors import BadInput
from recordings.recording import Bools

SEGMENTS = 15
"""Number of segments of a cycle if there is no other recording to validate on; every third one is a test segment."""
_MIN_SEGMENT = 5
"""Minimum length of a segment, in filter lengths."""


def split_recordings(train: Sequence[PreparedRecording], validate: Sequence[PreparedRecording]) -> SplitData:
    """Split recordings for training and recordings for validation; without the latter, split by phase segments."""
    recordings: Sequence[PreparedRecording] = [*train, *validate]
    standstill = in_threads(standstill_share, recordings)
    moving = list(map(moving_rows, recordings, standstill))
    count = len(train) if validate else None
    train_rows, test_rows = _subsets(recordings, moving, count)
    train_all, test_all = _subsets(recordings, [recording.usable for recording in recordings], count)
    _check_rows(recordings, train_rows, test_rows)
    weights = row_weights(recordings, train_rows, standstill)
    recordings = bound_to_bodies(recordings, train_rows, weights)
    size, usable = cache_size(recordings), sum(int(recording.usable.sum()) for recording in recordings)
    return SplitData(
        tuple(TorquePredictor(recording, size) for recording in recordings),
        train_rows,
        test_rows,
        tuple(np.where(rows, weight, 0.0) for rows, weight in zip(train_rows, weights, strict=True)),
        bool(validate),
        1 - sum(int(rows.sum()) for rows in moving) / max(usable, 1),
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


def _subsets(
    recordings: Sequence[PreparedRecording], usable: Sequence[Bools], count: int | None
) -> tuple[tuple[Bools, ...], tuple[Bools, ...]]:
    """Training and test rows (m, dof) of recordings: the first `count` are for training; None: parts of each are."""
    unused = [np.zeros_like(rows) for rows in usable]
    if count is not None:
        return (*usable[:count], *unused[count:]), (*unused[:count], *usable[count:])
    train, test = zip(*map(_split_by_phase, recordings, usable), strict=True)
    return train, test


def _split_by_phase(recording: PreparedRecording, usable: Bools) -> tuple[Bools, Bools]:
    """Training and test rows: the same phase segments of all cycles, separated by the length of the filter.

    Whole cycles would leak: any function of phase that fits one cycle of a repeated motion fits the next.
    """
    phase = recording.phase if np.isfinite(recording.phase).any() else recording.time
    longest, reach = max(float(np.nanmax(phase)), 1 / recording.rate), filters.REACH / recording.bandwidth
    segments = 3 * max(1, min(SEGMENTS // 3, int(longest / (3 * _MIN_SEGMENT * reach))))
    guard, offset = reach * segments / longest, phase * segments / longest % 3
    # Rows without a phase are in neither set.
    train, test = (guard <= offset) & (offset <= 2 - guard), (2 + guard <= offset) & (offset <= 3 - guard)
    return usable & train[:, None], usable & test[:, None]
