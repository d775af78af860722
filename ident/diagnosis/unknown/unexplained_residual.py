"""Test whether the residual of a model is larger than the noise floor, and on which variables it depends."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ident.data import cycle_statistics
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.ripple.ripple import Vibration
from ident.diagnosis.ripple.ripple_search import HIGHEST, MIN_SAMPLES, SAME_SHARE
from ident.diagnosis.ripple.waves import least_squares, wave, wave_numbers
from ident.diagnosis.split.noise_floor import MIN_TORQUE_SHARE, NoiseFloor
from ident.diagnosis.split.split_data import SplitData
from ident.diagnosis.split.split_data import rms as rms_of
from ident.diagnosis.unknown.residual_dependence import ResidualDependence, find_dependences
from ident.dynamics.effects.periodogram import periodogram
from recordings.recording import Bools, Floats

MIN_JOINT_RATIO = 0.35
"""Dependences are searched only for joints with this share of the largest unexplained residual."""
_MAX_P_VALUE = 1e-3
"""p-value below which a repeating residual is significant."""


@dataclass(frozen=True, eq=False)
class UnexplainedResidual:
    """The structured residual of one model."""

    rms: Floats
    """(dof,) RMS of the structured part [N m]."""
    share: float
    """Structured share of the mean square of the residual, over all joints."""
    significant: bool
    """Whether the structured part is relevant."""
    variables: tuple[str, ...]
    """Variables on which it depends."""
    sentence: str
    dependences: tuple[ResidualDependence, ...]
    """Curves that explain a part of it."""


def estimate_unexplained(
    model: FittedModel, known: Sequence[ResidualDependence] | None = None
) -> UnexplainedResidual:
    """The residual of `model` above its noise floor.

    known: its dependences, if known; None: they are searched, joint by joint.
    """
    split, residuals, floor = model.split, model.residuals, model.noise_floor
    total = rms_of(residuals, split.scored)
    structured = np.sqrt(np.maximum(total**2 - floor.rms**2, 0.0))
    share = float((structured**2).sum() / (total**2).sum()) if total.any() else 0.0
    exceeds = total > floor.limit
    # Where the motion repeats, a structured residual does so, too; otherwise, more than noise is structure.
    repeats = exceeds & _repeating(split, residuals) if floor.source == "repetition" else exceeds
    vibrates = np.array([_is_vibration(model, joint) for joint in range(len(total))])
    drifts = np.sqrt([max(trend.mean_square, 0.0) if trend else 0.0 for trend in floor.trends]) > floor.least
    # A missing effect of one joint spreads to the others through shared parameters.
    worst = (structured / split.torque_rms) >= MIN_JOINT_RATIO * (structured / split.torque_rms).max()
    joints = [int(joint) for joint in np.flatnonzero((repeats & worst & ~vibrates) | drifts)]
    dependences = find_dependences(split, model.solution, residuals, joints) if known is None else list(known)
    variables = {variable for dependence in dependences for variable in dependence.variables}
    variables |= ({"time"} if drifts.any() else set()) | ({"frequency"} if vibrates.any() else set())
    significant = bool((repeats | vibrates | drifts).any())
    return UnexplainedResidual(
        structured,
        share,
        significant,
        tuple(sorted(variables)),
        _sentence(significant, dependences, floor, vibrates, drifts),
        tuple(dependences),
    )


def with_vibrations(
    unexplained: UnexplainedResidual, vibrations: Sequence[Vibration], torque_rms: Floats
) -> UnexplainedResidual:
    """Add relevant `vibrations` above the low-pass, which are as unexplained as those below it.

    Its RMS and its share are still those of the residual below the low-pass. torque_rms: (dof,) [N m].
    """
    least = MIN_TORQUE_SHARE * torque_rms
    clauses = [
        _vibration(each.joint, each.frequency)
        for each in vibrations
        if each.amplitude / np.sqrt(2) > least[each.joint]
    ]
    if not clauses:
        return unexplained
    known = [unexplained.sentence.removesuffix(".")] if unexplained.significant else []
    return replace(
        unexplained,
        significant=True,
        variables=tuple(sorted({*unexplained.variables, "frequency"})),
        sentence="; ".join([*known, *clauses]) + ".",
    )


def _is_vibration(model: FittedModel, joint: int) -> bool:
    """Whether the line in the residual of a `joint` is relevant, and no frequency of the motion itself."""
    line = model.noise_floor.lines[joint]
    if line is None or line.mean_square < model.noise_floor.least[joint] ** 2:
        return False
    if model.noise_floor.source == "repetition":  # it differs between repetitions: it is none of the motion
        return True
    data = zip(model.split.recordings, model.computed, model.residuals, strict=True)
    for recording, computed, residual in data:
        known = np.isfinite(residual[:, joint])
        if known.sum() < MIN_SAMPLES:
            continue
        columns = wave(recording.time[known], 2 * np.pi * line.frequency)
        signal, rest = (x[known, joint] - x[known, joint].mean() for x in (computed, residual))
        motion, over_time = (least_squares(columns, x) for x in (signal, rest))
        if motion @ motion / 2 > line.mean_square:
            return False
        angle = recording.motion.position[known, joint]
        grid = wave_numbers(angle, HIGHEST)
        reduction = float(np.sum((columns @ over_time) ** 2))
        if len(grid) and periodogram(angle, rest, grid).max() > SAME_SHARE * reduction:
            return False  # it may as well be ripple over the angle
    return True


def _vibration(joint: int, frequency: float) -> str:
    return f"joint {joint + 1}: a vibration of {frequency:.2f} Hz"


def _sentence(
    significant: bool, dependences: Sequence[ResidualDependence], floor: NoiseFloor, vibrates: Bools, drifts: Bools
) -> str:
    if not significant:
        return "only noise and encoder quantization."
    clauses = _clauses(dependences)
    for joint, line in enumerate(floor.lines):
        if vibrates[joint] and line:
            clauses.append(_vibration(joint, line.frequency))
    for joint, trend in enumerate(floor.trends):
        if drifts[joint] and trend:
            kind = "from cycle to cycle" if trend.pattern == "linear" else f"at one instant ({trend.pattern})"
            clauses.append(f"joint {joint + 1}: it changes {kind}")
    what = "it repeats with the motion" if floor.source == "repetition" else "it exceeds the noise"
    return "; ".join(clauses) + "." if clauses else f"{what}, but depends on no single variable."


def _clauses(dependences: Sequence[ResidualDependence]) -> list[str]:
    return [
        f"joint {dependence.joint + 1}: {dependence.explained:.0%} of it depends on "
        f"{' and '.join(dependence.variables)}"
        for dependence in dependences
    ]


def _repeating(split: SplitData, residuals: tuple[Floats, ...]) -> Bools:
    """(dof,) whether the residual repeats with the motion significantly."""
    statistics = cycle_statistics.of_residuals(split.recordings, residuals) or ()
    return np.array([statistic.repeating_p < _MAX_P_VALUE for statistic in statistics])
