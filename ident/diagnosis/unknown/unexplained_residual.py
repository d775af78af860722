"""Test whether the residual of a model is larger than the noise floor, and on which variables it depends."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ident.data import cycle_statistics
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import MIN_SHARE
from ident.diagnosis.ripple.lines import Vibration
from ident.diagnosis.ripple.waves import least_squares, wave
from ident.diagnosis.split.noise_floor import MIN_TORQUE_SHARE
from ident.diagnosis.split.split_data import rms as rms_of
from ident.diagnosis.unknown.residual_dependence import ResidualDependence, find_dependences
from recordings.recording import Floats

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
    joints: tuple[int, ...]
    """Joints (from 0) in which it is searched: those where it is large and no vibration."""
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
    repeats = total > floor.limit
    # Where the motion repeats, a structured residual does so, too; otherwise, more than noise is structure.
    if statistics := cycle_statistics.of_residuals(split.recordings, residuals):
        repeats &= np.array([each.repeating_p for each in statistics]) < _MAX_P_VALUE
    vibrates = np.array([_is_vibration(model, joint) for joint in range(len(total))])
    drifts = np.sqrt([max(trend.mean_square, 0.0) if trend else 0.0 for trend in floor.trends]) > floor.least
    relative = structured / split.torque_rms
    # A missing effect of one joint spreads to the others through shared parameters.
    large = relative**2 >= MIN_SHARE * (relative**2).max()
    searched = (repeats & large & ~vibrates) | drifts
    if known is None:
        known = find_dependences(split, model.solution, residuals, np.flatnonzero(searched).tolist())
    variables = {variable for dependence in known for variable in dependence.variables}
    variables |= ({"time"} if drifts.any() else set()) | ({"frequency"} if vibrates.any() else set())
    clauses = [
        f"joint {each.joint + 1}: {each.explained:.0%} of it depends on {' and '.join(each.variables)}"
        for each in known
    ]
    for joint, (line, trend) in enumerate(zip(floor.lines, floor.trends, strict=True)):
        if line and vibrates[joint]:
            clauses.append(_vibration(joint, line.frequency))
        if trend and drifts[joint]:
            kind = "from cycle to cycle" if trend.pattern == "linear" else f"at one instant ({trend.pattern})"
            clauses.append(f"joint {joint + 1}: it changes {kind}")
    what = "it repeats with the motion" if floor.source == "repetition" else "it exceeds the noise"
    significant = bool((repeats | vibrates | drifts).any())
    sentence = "; ".join(clauses or [f"{what}, but depends on no single variable"]) + "."
    return UnexplainedResidual(
        structured,
        float((structured**2).sum() / (total**2).sum()) if total.any() else 0.0,
        significant,
        tuple(sorted(variables)),
        sentence if significant else "only noise and encoder quantization.",
        tuple(np.flatnonzero(searched).tolist()),
        tuple(known),
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


def _vibration(joint: int, frequency: float) -> str:
    return f"joint {joint + 1}: a vibration of {frequency:.2f} Hz"


def _is_vibration(model: FittedModel, joint: int) -> bool:
    """Whether the line in the residual of a `joint` is relevant, and no frequency of the motion itself."""
    line = model.noise_floor.lines[joint]
    if line is None or line.mean_square < model.noise_floor.least[joint] ** 2:
        return False
    if model.noise_floor.source == "repetition":  # it differs between repetitions: it is none of the motion
        return True
    for recording, computed in zip(model.split.recordings, model.computed, strict=True):
        known = np.isfinite(computed[:, joint])
        signal = computed[known, joint] - computed[known, joint].mean()
        of_line = least_squares(wave(recording.time[known], 2 * np.pi * line.frequency), signal)
        if of_line @ of_line / 2 > line.mean_square:
            return False
    return True
