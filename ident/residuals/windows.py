"""Time windows of a recording with the largest residual."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ident.identification.prediction import Prediction
from ident.residuals.phases import phases
from recordings.recording import Floats

DURATION = 0.25
"""[s]"""
MIN_KNOWN_SHARE = 0.8
"""A window with a smaller share of usable samples is not evaluated."""


@dataclass(frozen=True)
class Window:
    """A time window of one recording in which the residual of one joint is large."""

    recording: str
    joint: int
    """Numbered from 1."""
    start: float
    end: float
    """[s] since the recording's first SYNC."""
    rms: float
    """[N m or N]"""
    mean: float
    """[N m or N]"""
    times_overall: float
    """RMS in the window over the RMS of the joint in all recordings."""
    phase: str
    """Phase of the motion with most of the squared residual in the window."""
    cycle: int | None
    """Repetition of the motion, numbered from 1."""


def worst_windows(predictions: Sequence[Prediction], count: int) -> tuple[Window, ...]:
    """Return the `count` windows with the largest RMS relative to their joint's RMS, worst first.

    Windows of one joint do not overlap, and no two of them are in the same part of a repeated motion.
    """
    square = np.concatenate([prediction.scored_residual**2 for prediction in predictions])
    overall = np.sqrt(np.nanmean(square, axis=0))
    windows = [
        window
        for prediction in predictions
        for joint in range(len(overall))
        if overall[joint] > 0
        for window in _joint_windows(prediction, joint, float(overall[joint]), count)
    ]
    return tuple(sorted(windows, key=lambda window: -window.times_overall)[:count])


def _joint_windows(prediction: Prediction, joint: int, overall: float, count: int) -> list[Window]:
    prepared, residual = prediction.prepared, prediction.scored_residual[:, joint]
    length = max(1, round(DURATION * prepared.rate))
    rms = _moving_rms(residual, length)
    phase = phases(prepared)[:, joint]
    windows: list[Window] = []
    while len(windows) < count and np.isfinite(rms).any():
        first = int(np.nanargmax(rms))
        inside = slice(first, first + length)
        known = np.isfinite(residual[inside])
        repeat = int(prepared.repeat[inside][length // 2])
        windows.append(
            Window(
                recording=prepared.recording.path.name,
                joint=joint + 1,
                start=float(prepared.time[first]),
                end=float(prepared.time[first]) + length / prepared.rate,
                rms=float(rms[first]),
                mean=float(residual[inside][known].mean()),
                times_overall=float(rms[first]) / overall,
                phase=_phase(phase[inside][known], residual[inside][known]),
                cycle=repeat + 1 if repeat >= 0 else None,
            )
        )
        rms[max(0, first - length + 1) : first + length] = np.nan
        rms[np.abs(prepared.phase[: len(rms)] - prepared.phase[first]) < DURATION] = np.nan
    return windows


def _phase(phase: NDArray[np.str_], residual: Floats) -> str:
    """The phase with most of the squared `residual` (m,), from those (m,) of its known rows."""
    names, place = np.unique(phase, return_inverse=True)
    return str(names[np.bincount(place, residual**2).argmax()])


def _moving_rms(residual: Floats, length: int) -> Floats:
    """(m - length + 1,) RMS of the known samples in the window from each sample on; NaN if too few are known."""
    known = np.isfinite(residual)
    samples, square = (
        np.convolve(values, np.ones(length), "valid") for values in (known, np.where(known, residual, 0.0) ** 2)
    )
    return np.sqrt(square / np.where(samples >= MIN_KNOWN_SHARE * length, samples, np.nan))
