"""Residual by joint and by phase of the motion."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ident.data.prepared_recording import PreparedRecording
from ident.identification.prediction import Prediction
from recordings.recording import Floats

Bools = NDArray[np.bool_]

PHASES = ("standstill", "reversal", "acceleration", "cruise")

SLOW_SHARE = 0.05
"""A joint is slow below this share of its RMS speed."""
REVERSAL_PERIODS = 1.5
"""Samples within so many periods of the analysis bandwidth are near a reversal: the low-pass smears it so far."""
NOTABLE_FACTOR = 1.5
"""A residual larger than elsewhere by this factor is reported."""


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
