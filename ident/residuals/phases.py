"""Residual by joint, by phase of the motion, and in the time windows where it is largest."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ident.data.prepared_recording import PreparedRecording
from ident.identification.prediction import Prediction
from recordings.recording import Bools, Floats

PHASES = ("standstill", "reversal", "acceleration", "cruise")

SLOW_SHARE = 0.05
"""A joint is slow below this share of its RMS speed."""
REVERSAL_PERIODS = 1.5
"""Samples within so many periods of the analysis bandwidth are near a reversal: the low-pass smears it so far."""
NOTABLE_FACTOR = 1.5
"""A residual larger than elsewhere by this factor is reported."""
DURATION = 0.25
"""Of a window [s]."""
MIN_KNOWN_SHARE = 0.8
"""A window with a smaller share of usable samples is not evaluated."""


@dataclass(frozen=True)
class Phase:
    """The residual of one joint in one phase."""

    rms: float
    """[N m or N]"""
    time_share: float
    """Share of the samples, 0 to 1."""
    error_share: float
    """Share of the residual's sum of squares, 0 to 1."""
    times_elsewhere: float
    """RMS residual in this phase over that in all others; 1 if there are no others or their residual is zero."""


@dataclass(frozen=True)
class JointResidual:
    """The residual of one joint."""

    number: int
    rms: float
    """In scored rows [N m]."""
    rms_all: float
    """In all usable rows, with those near standstill or near the limit of the amplifiers [N m]."""
    share: float
    """RMS residual over RMS torque."""
    phases: Mapping[str, Phase]
    """Occurring phases by name."""

    @property
    def sentences(self) -> tuple[str, ...]:
        """Name the phase with most of the squared residual, if the residual is larger there than elsewhere."""
        name, phase = max(self.phases.items(), key=lambda item: item[1].error_share)
        if phase.times_elsewhere < NOTABLE_FACTOR:
            return ()
        return (
            f"Joint {self.number}: phase '{name}' has {100 * phase.error_share:.0f} % of the squared residual, in "
            f"{100 * phase.time_share:.0f} % of the time.",
        )


def joint_residuals(predictions: Sequence[Prediction]) -> tuple[JointResidual, ...]:
    """Residual of each joint in the scored rows of all `predictions`."""
    scored, whole, torque, phase = (
        np.concatenate(parts)
        for parts in zip(
            *(
                (each.scored_residual, each.residual, each.prepared.torque, phases(each.prepared))
                for each in predictions
            ),
            strict=True,
        )
    )
    return tuple(_joint(i + 1, scored[:, i], whole[:, i], torque[:, i], phase[:, i]) for i in range(scored.shape[1]))


def phases(prepared: PreparedRecording) -> NDArray[np.str_]:
    """(m, dof) phase of each joint's motion: near a reversal, standstill, acceleration, or else cruise."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    velocity, acceleration = (np.nan_to_num(x) for x in (prepared.motion.velocity, prepared.motion.acceleration))
    slow = SLOW_SHARE * np.sqrt(np.mean(velocity**2, axis=0))
    window = 2 * max(1, round(REVERSAL_PERIODS / prepared.bandwidth * prepared.rate)) + 1
    fastest, slowest = maximum_filter1d(velocity, window, axis=0), minimum_filter1d(velocity, window, axis=0)
    return np.select(
        [
            (fastest > slow) & (slowest < -slow),
            np.abs(velocity) < slow,
            np.abs(acceleration) > np.sqrt(np.mean(acceleration**2, axis=0)),
        ],
        ["reversal", "standstill", "acceleration"],
        "cruise",
    )


def _joint(number: int, residual: Floats, whole: Floats, torque: Floats, phase: NDArray[np.str_]) -> JointResidual:
    usable = np.isfinite(residual)
    square, phase = residual[usable] ** 2, phase[usable]
    rms = float(np.sqrt(square.mean()))
    occurring = {name: phase == name for name in PHASES if (phase == name).any()}
    return JointResidual(
        number,
        rms,
        rms_all=float(np.sqrt(np.nanmean(whole**2))),
        share=rms / float(np.sqrt(np.mean(torque[usable] ** 2))),
        phases={name: _phase(square, inside) for name, inside in occurring.items()},
    )


def _phase(square: Floats, inside: Bools) -> Phase:
    elsewhere = square[~inside].mean() if not inside.all() else 0.0
    return Phase(
        rms=float(np.sqrt(square[inside].mean())),
        time_share=float(inside.mean()),
        error_share=float(square[inside].sum() / square.sum()) if square.any() else 0.0,
        times_elsewhere=float(np.sqrt(square[inside].mean() / elsewhere)) if elsewhere else 1.0,
    )


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
                phase=_worst_phase(phase[inside][known], residual[inside][known]),
                cycle=repeat + 1 if repeat >= 0 else None,
            )
        )
        rms[max(0, first - length + 1) : first + length] = np.nan
        rms[np.abs(prepared.phase[: len(rms)] - prepared.phase[first]) < DURATION] = np.nan
    return windows


def _worst_phase(phase: NDArray[np.str_], residual: Floats) -> str:
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
