"""What a model leaves: whether it is more than the floor, and what it depends on."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ident.data import cycle_statistics
from ident.diagnosis.noise_floor import NoiseFloor
from ident.diagnosis.residual_dependence import Dependence, find_dependences
from ident.diagnosis.split_data import SplitData
from ident.diagnosis.split_data import rms as rms_of
from ident.diagnosis.steps import FittedModel
from recordings.recording import Bools, Floats

MIN_TORQUE_SHARE = 0.0035
"""Share of the torque below which a remainder is not called structure: what preprocessing may leave of a right
model."""
_UNSURE = 0.6
"""Relative uncertainty of what encoder steps leave."""
_SCATTER = 0.25
"""Of the noise's RMS that an estimate of it may be wrong by, and more."""
_CLEARLY = 0.35
"""Only joints with so much of the worst one's remainder are asked what theirs depends on."""
_CHANCE = 1e-3
"""Probability below which a repeating remainder is not called chance."""


@dataclass(frozen=True, eq=False)
class UnexplainedResidual:
    """Of one model."""

    rms: Floats
    """(dof,) of what is structured [N m]."""
    share: float
    """Of the remaining mean square, over all joints."""
    significant: bool
    """Whether there is structure in it that matters."""
    variables: tuple[str, ...]
    """What it depends on."""
    sentence: str
    dependences: tuple[Dependence, ...]
    """What the curves are over that explain some of it."""


def estimate_unexplained(material: SplitData, state: FittedModel, floor: NoiseFloor, known: Sequence[Dependence] | None = None) -> UnexplainedResidual:
    """What the model `state` leaves above its `floor`.

    known: what it is known to depend on; None: it is looked at, joint by joint.
    """
    residuals = state.residuals
    total = rms_of(residuals, material.scored)
    structured = np.sqrt(np.maximum(total**2 - floor.rms**2, 0.0))
    share = float((structured**2).sum() / (total**2).sum()) if total.any() else 0.0
    least = MIN_TORQUE_SHARE * material.torque_rms
    doubtful = np.sqrt(least**2 + (_UNSURE * floor.encoder) ** 2 + (_SCATTER * floor.noise) ** 2)
    repeats = (structured > doubtful) & _repeating(material, residuals)
    vibrates = np.sqrt([one.mean_square if one else 0.0 for one in floor.lines]) > least
    drifts = np.sqrt([max(one.mean_square, 0.0) if one else 0.0 for one in floor.trends]) > least
    # What one joint lacks spreads to the others through the parameters that they share.
    worst = (structured / material.torque_rms) >= _CLEARLY * (structured / material.torque_rms).max()
    joints = [int(joint) for joint in np.flatnonzero((repeats & worst & ~vibrates) | drifts)]
    found = find_dependences(material, state.solution, residuals, joints) if known is None else list(known)
    variables = {variable for one in found for variable in one.variables}
    variables |= ({"time"} if drifts.any() else set()) | ({"frequency"} if vibrates.any() else set())
    unexplained = bool((repeats | vibrates | drifts).any())
    return UnexplainedResidual(
        structured,
        share,
        unexplained,
        tuple(sorted(variables)),
        _sentence(unexplained, found, floor, vibrates, drifts),
        tuple(found),
    )


def _sentence(unexplained: bool, found: Sequence[Dependence], floor: NoiseFloor, vibrates: Bools, drifts: Bools) -> str:
    if not unexplained:
        return "nothing that repeats with the motion, or that noise could not have made."
    parts = [
        f"joint {one.joint + 1}: {one.explained:.0%} of it goes with {' and '.join(one.variables)}" for one in found
    ]
    for joint, line in enumerate(floor.lines):
        if vibrates[joint] and line:
            parts.append(f"joint {joint + 1}: a vibration of {line.frequency:.2f} Hz")
    parts += [f"joint {joint + 1}: it changes from cycle to cycle" for joint in np.flatnonzero(drifts)]
    return "; ".join(parts) + "." if parts else "it repeats with the motion, but goes with no single variable."


def _repeating(material: SplitData, residuals: tuple[Floats, ...]) -> Bools:
    """(dof,) whether the residual repeats with the motion by more than chance; True where nothing tells."""
    splits = cycle_statistics.of(material.datasets, residuals)
    if not splits:
        return np.ones(residuals[0].shape[1], bool)
    return np.array([one.repeating_p < _CHANCE for one in splits])
