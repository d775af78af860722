"""What the last model leaves: whether it is more than the floor, and what it depends on."""

from dataclasses import dataclass

import numpy as np

from ident import repetition
from ident.diagnose.ladder import Ladder
from ident.diagnose.material import Material
from ident.diagnose.material import rms as rms_of
from recordings.recording import Bools, Floats

LEAST = 0.0035
"""Share of the torque below which a remainder is not called structure: what preprocessing may leave of a right
model."""
_UNSURE = 0.6
"""Relative uncertainty of what encoder steps leave."""
_CHANCE = 1e-3
"""Probability below which a repeating remainder is not called chance."""


@dataclass(frozen=True, eq=False)
class Remainder:
    """Of the last model."""

    rms: Floats
    """(dof,) of what is structured [N m]."""
    share: float
    """Of the remaining mean square, over all joints."""
    unexplained: bool
    """Whether there is structure in it that matters."""
    variables: tuple[str, ...]
    """What it depends on."""
    sentence: str


def remainder(material: Material, ladder: Ladder) -> Remainder:
    """What the top of the `ladder` leaves."""
    residuals = ladder.rungs[-1].state.residuals
    rows = [seen | held for seen, held in zip(material.seen, material.held, strict=True)]
    total = rms_of(residuals, rows)
    structured = np.sqrt(np.maximum(total**2 - ladder.floor.rms**2, 0.0))
    share = float((structured**2).sum() / (total**2).sum()) if total.any() else 0.0
    repeating = _repeating(material, residuals)
    least = np.hypot(LEAST * material.torque_rms, _UNSURE * ladder.floor.encoder)
    matters = (structured > np.hypot(least, 0.25 * ladder.floor.noise)) & repeating
    vibrates = np.array(
        [
            line is not None and line.mean_square > floor_**2
            for line, floor_ in zip(ladder.floor.lines, LEAST * material.torque_rms, strict=True)
        ]
    )
    drifts = np.array(
        [
            trend is not None and trend.mean_square > floor_**2
            for trend, floor_ in zip(ladder.floor.trends, LEAST * material.torque_rms, strict=True)
        ]
    )
    unexplained = bool((matters | vibrates | drifts).any())
    variables = (*(("time",) if drifts.any() else ()), *(("frequency",) if vibrates.any() else ()))
    sentence = "what is left does not repeat with the motion: noise" if not unexplained else "it repeats"
    return Remainder(structured, share, unexplained, variables, sentence)


def _repeating(material: Material, residuals: tuple[Floats, ...]) -> Bools:
    """(dof,) whether the residual repeats with the motion by more than chance; True where nothing tells."""
    splits = repetition.of(material.datasets, residuals)
    if not splits:
        return np.ones(residuals[0].shape[1], bool)
    return np.array([one.repeating_p < _CHANCE for one in splits])
