"""Rows of recordings that count in a weighted fit, and their weights: the same for a fit and a diagnosis."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ident.data import noise
from ident.data.prepared_recording import PreparedRecording
from ident.data.quantization import with_encoder_errors
from recordings.recording import Bools, Floats

MAX_STANDSTILL = 0.25
"""Rows with a larger share of standstill are left out."""
_DEVIATIONS = 3.0
"""Speeds within this many standard deviations of the quantization error are standstill."""
_CREEPING = 0.02
"""Share of the largest speed: below it, dry friction is between its two levels in any machine."""
_MIN_CREEPING_SHARE = 0.5
"""Share of creeping instants behind a row from which it is a standstill rather than a reversal."""


@dataclass(frozen=True, eq=False)
class FittedRows:
    """Rows of recordings that a weighted fit uses."""

    recordings: Sequence[PreparedRecording]
    rows: list[Bools]
    """(m, dof) of each recording."""
    standstill: list[Floats]
    """(m, dof) `standstill_share` of each recording."""
    weights: list[Floats]
    """(m, dof) 1 / standard deviation of each row [1 / (N m)]."""

    def reweighted(self, residuals: Sequence[Floats]) -> "FittedRows":
        """Return the rows with weights by the `residuals` (m, dof) of a better model than the mechanism alone."""
        return replace(self, weights=row_weights(self.recordings, self.rows, self.standstill, residuals))

    @property
    def fit_weights(self) -> list[Floats]:
        """(m, dof) weights of each recording; 0 where a row is not fitted."""
        return [np.where(rows, weights, 0.0) for rows, weights in zip(self.rows, self.weights, strict=True)]


def moving_rows(recording: PreparedRecording, standstill: Floats) -> Bools:
    """(m, dof) usable rows in which a joint moves, by its shares of `standstill` (m, dof)."""
    return recording.usable & (standstill < MAX_STANDSTILL)


def moving_or_all(recording: PreparedRecording, standstill: Floats) -> Bools:
    """(m, dof) `moving_rows`; all usable ones of a joint that never moves."""
    moving = moving_rows(recording, standstill)
    return np.where(moving.any(axis=0), moving, recording.usable)


def fitted_rows(recordings: Sequence[PreparedRecording]) -> FittedRows:
    """Return the rows of `recordings` that a weighted fit uses."""
    standstill = list(map(standstill_share, recordings))
    rows = list(map(moving_or_all, recordings, standstill))
    return FittedRows(recordings, rows, standstill, row_weights(recordings, rows, standstill))


def row_weights(
    recordings: Sequence[PreparedRecording],
    train: Sequence[Bools],
    standstill: Sequence[Floats],
    residuals: Sequence[Floats] | None = None,
) -> list[Floats]:
    """1 / standard deviation of every row (m, dof), from noise, `residuals` (m, dof) and standstill.

    Only the rows `train` (m, dof) are fitted, and tell the noise.

    residuals: of each recording; None: those of a first fit of the mechanism.
    """
    indices = [i for i, rows in enumerate(train) if rows.any()]
    residuals = _first_residuals(recordings, train, indices) if residuals is None else residuals
    noise_models = noise.estimate([recordings[i] for i in indices], [residuals[i] for i in indices])
    # Only fitted rows tell how good the model is; of a joint that is not fitted in a recording, all do.
    fitted = [np.where(rows | ~rows.any(axis=0), x, np.nan) for x, rows in zip(residuals, train, strict=True)]
    return [
        1 / np.hypot(noise.residual_std(recording, residual, noise_models), still)
        for recording, residual, still in zip(recordings, fitted, standstill, strict=True)
    ]


def _first_residuals(
    recordings: Sequence[PreparedRecording], train: Sequence[Bools], indices: Sequence[int]
) -> list[Floats]:
    """(m, dof) of each recording, what a fit of the mechanism to the rows `train` (m, dof) of `indices` leaves."""
    regressor = np.concatenate([recordings[i].regressor[train[i]] for i in indices])
    # Joints of an arm differ in size by ten and more, and in unit: none may outweigh the others.
    joint_size = _rms([np.where(train[i], recordings[i].torque, np.nan) for i in indices])
    torque = np.concatenate([recordings[i].torque[train[i]] for i in indices])
    size = np.concatenate([np.broadcast_to(joint_size, rows.shape)[rows] for rows in (train[i] for i in indices)])
    parameters = np.linalg.lstsq(regressor / size[:, None], torque / size, rcond=None)[0]
    return [recording.torque - recording.regressor @ parameters for recording in recordings]


def _rms(torques: Sequence[Floats]) -> Floats:
    """(dof,) RMS of the torque [N m or N]; 1 for a joint without any."""
    torque = np.concatenate(torques)
    squares = np.nansum(torque**2, axis=0) / np.maximum(np.isfinite(torque).sum(axis=0), 1)
    return np.sqrt(np.where(squares > 0, squares, 1.0))


def standstill_share(recording: PreparedRecording) -> Floats:
    """(m, dof) share of the instants behind a row at which a joint is too slow for its direction to be known.

    Dry friction may then be anywhere between its two levels. The threshold follows from the encoder steps.
    """
    motion, perturbed = recording.as_recorded.motion, with_encoder_errors(recording).as_recorded.motion
    threshold = _DEVIATIONS * np.nanstd(perturbed.velocity - motion.velocity, axis=0)
    speed = np.abs(motion.velocity)
    unsure, creeping = (
        np.clip(recording.condition(np.where(np.isfinite(speed), speed < limit, np.nan)), 0.0, 1.0)
        for limit in (threshold, _CREEPING * np.nanmax(speed, axis=0))
    )
    return np.maximum(unsure, np.where(creeping > _MIN_CREEPING_SHARE, creeping, 0.0))
