"""Plain words on where a model fails: which joint, and in which phase of its motion."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ident.data.dataset import Dataset
from ident.identification.identify import Identification
from recordings.recording import Floats

Bools = NDArray[np.bool_]

PHASES = ("standstill", "reversal", "acceleration", "cruise")
HINTS = {
    "standstill": "look at friction at rest and at constant torques (gravity, offset)",
    "reversal": "look at friction near standstill, and at play",
    "acceleration": "look at inertia, elasticity, and a delay between voltage and position",
    "cruise": "look at friction over speed, and at what depends on position",
}

SLOW_SHARE = 0.05
"""A joint is slow below this share of its RMS speed."""
REVERSAL_PERIODS = 1.5
"""A reversal is near within so many periods of the analysis bandwidth: so far the low-pass smears it."""
NOTABLE_FACTOR = 1.5
"""A residual that is larger than elsewhere by this factor is worth a sentence."""
MIN_TIME_SHARE = 0.02
"""A phase that takes less of the time than this is not judged."""


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
    """RMS residual in this phase over that in all others; 1 where there are none, or nothing is left in them."""


@dataclass(frozen=True)
class JointResidual:
    """The residual of one joint."""

    number: int
    rms: float
    """[N m]"""
    share: float
    """RMS residual over RMS torque."""
    phases: Mapping[str, Phase]
    """By name, those that occur."""


def fit_sentences(result: Identification) -> tuple[str, ...]:
    """Sentences on where a fitted model fails: on its validation recording if there is one, else on the training data."""
    trained = joint_residuals(result.train, [result.fit.torque(dataset) for dataset in result.train])
    if result.validation is None:
        return sentences(trained)
    return sentences(joint_residuals([result.validation], [result.fit.torque(result.validation)]), trained)


def joint_residuals(datasets: Sequence[Dataset], computed: Sequence[Floats]) -> tuple[JointResidual, ...]:
    """The residual of each joint over all `datasets`, given the torque (m, dof) [N m] computed for each."""
    residual = np.concatenate([dataset.torque - torque for dataset, torque in zip(datasets, computed, strict=True)])
    torque = np.concatenate([dataset.torque for dataset in datasets])
    phase = np.concatenate([phases(dataset) for dataset in datasets])
    return tuple(_joint(i + 1, residual[:, i], torque[:, i], phase[:, i]) for i in range(residual.shape[1]))


def phases(dataset: Dataset) -> NDArray[np.str_]:
    """(m, dof) phase of each joint's motion: near a reversal, standing still, accelerating, or else cruising."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    velocity, acceleration = (np.nan_to_num(x) for x in (dataset.motion.velocity, dataset.motion.acceleration))
    slow = SLOW_SHARE * np.sqrt(np.mean(velocity**2, axis=0))
    window = 2 * max(1, round(REVERSAL_PERIODS / dataset.bandwidth * dataset.rate)) + 1
    fastest, slowest = maximum_filter1d(velocity, window, axis=0), minimum_filter1d(velocity, window, axis=0)
    names: NDArray[np.str_] = np.select(
        [
            (fastest > slow) & (slowest < -slow),
            np.abs(velocity) < slow,
            np.abs(acceleration) > np.sqrt(np.mean(acceleration**2, axis=0)),
        ],
        ["reversal", "standstill", "acceleration"],
        "cruise",
    )
    return names


def sentences(evaluated: Sequence[JointResidual], training: Sequence[JointResidual] = ()) -> tuple[str, ...]:
    """What stands out in the residuals `judged`, in words; what to look at is a hint, no finding.

    `trained` are the residuals of the data that the fit saw, where those judged are of another recording.
    """
    shares = ", ".join(f"joint {joint.number} {100 * joint.share:.1f}" for joint in evaluated)
    standing_out = [*_worst_joint(evaluated), *_worst_phases(evaluated), *_transfer(evaluated, training)]
    return (
        f"Residual, in percent of the torque: {shares}.",
        *(standing_out or ["No joint and no phase of the motion stands out."]),
    )


def _worst_joint(joints: Sequence[JointResidual]) -> Iterator[str]:
    worst = max(joints, key=lambda joint: joint.share)
    others = [joint.share for joint in joints if joint is not worst]
    if others and worst.share > NOTABLE_FACTOR * float(np.median(others)):
        yield f"Joint {worst.number} leaves most: look at what is particular to it."


def _worst_phases(joints: Sequence[JointResidual]) -> Iterator[str]:
    for joint in joints:
        judged = {name: phase for name, phase in joint.phases.items() if phase.time_share >= MIN_TIME_SHARE}
        name, phase = max(judged.items(), key=lambda item: item[1].times_elsewhere, default=("", None))
        if phase and phase.times_elsewhere > NOTABLE_FACTOR:
            yield (
                f"Joint {joint.number}: {phase.times_elsewhere:.1f} times larger in phase '{name}' than elsewhere "
                f"({100 * phase.time_share:.0f} % of the time, {100 * phase.error_share:.0f} % of the squared "
                f"error): {HINTS[name]}."
            )


def _transfer(judged: Sequence[JointResidual], trained: Sequence[JointResidual]) -> Iterator[str]:
    growth = [one.share / other.share for one, other in zip(judged, trained, strict=False) if other.share]
    if growth and float(np.median(growth)) > NOTABLE_FACTOR:
        yield (
            f"Against the training data the residual has grown {np.median(growth):.1f} times: the parameters do not "
            "carry over to this motion, as when a physical effect is missing."
        )


def _joint(number: int, residual: Floats, torque: Floats, phase: NDArray[np.str_]) -> JointResidual:
    usable = np.isfinite(residual)
    square, phase = residual[usable] ** 2, phase[usable]
    rms = float(np.sqrt(square.mean()))
    occurring = {name: phase == name for name in PHASES if (phase == name).any()}
    return JointResidual(
        number,
        rms,
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
