"""Confounding of Coulomb friction and a constant offset, if a joint moves mainly in one direction.

With one direction of motion both are indistinguishable; the rows in the rarer direction discriminate them.
"""

from collections.abc import Iterator

import numpy as np

from ident.diagnosis.split.parameter_intervals import parameter_uncertainty
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.effects.base import Effect
from ident.dynamics.structure import ModelStructure, Term
from ident.estimation.nonlinear_fit import Solution
from recordings.recording import Floats

MAX_RARE_SHARE = 0.25
"""A direction is rare below this share of the moving time."""
_OFFSET = "torque_offset"


def confounding_warnings(split: SplitData, solution: Solution, offset: Effect | None) -> Iterator[str]:
    """Yield a sentence for each joint with a rare direction, with both estimates and their intervals.

    offset: the effect that is added to the model for this purpose.
    """
    shares = rarer_direction_share(split)
    for joint in np.flatnonzero(shares < MAX_RARE_SHARE):
        if not shares[joint]:
            yield (
                f"Joint {joint + 1} moves in one direction only, so Coulomb friction and a constant offset cannot be "
                "distinguished."
            )
        elif offset:
            yield _warning(split, _with_offset(split, solution, offset, int(joint)), int(joint), float(shares[joint]))


def rarer_direction_share(split: SplitData) -> Floats:
    """(dof,) share of the moving training rows that move in the rarer direction."""
    forwards, backwards = (
        sum(
            (train & (sign * predictor.prepared.motion.velocity > 0)).sum(axis=0)
            for predictor, train in zip(split.predictors, split.train, strict=True)
        )
        for sign in (1.0, -1.0)
    )
    share: Floats = np.minimum(forwards, backwards) / np.maximum(forwards + backwards, 1)
    return share


def _with_offset(split: SplitData, solution: Solution, offset: Effect, joint: int) -> Solution:
    """The model with an offset on that joint; unchanged if it already has one."""
    structure: ModelStructure = solution.structure
    if any(term.name == _OFFSET and joint in term.joints for term in structure.terms):
        return solution
    return split.fit(structure.with_term(Term(_OFFSET, offset, (joint,))), np.append(solution.x, 0.0))


def _warning(split: SplitData, solution: Solution, joint: int, share: float) -> str:
    entries = solution.structure.parameters
    friction = next(i for i, entry in enumerate(entries) if entry.name == f"c_c{joint + 1}")
    names = [entry.name.partition(".") for entry in entries]  # a second term of the effect is numbered: "#2"
    constant = next(
        i for i, (effect, _, name) in enumerate(names) if effect.startswith(_OFFSET) and name == f"a{joint + 1}"
    )
    uncertainty = parameter_uncertainty(split, solution)
    width, rho = uncertainty.half_width(), uncertainty.correlation[friction, constant]
    rarely = (
        f"Joint {joint + 1} moves in one of its directions only {share:.0%} of the time, so Coulomb friction and a"
    )
    if not np.isfinite(rho):
        return f"{rarely} constant offset cannot be distinguished."
    texts = [f"{solution.x[i]:.3g} ± {width[i]:.2g} {entries[i].unit}" for i in (friction, constant)]
    return (
        f"{rarely} constant offset are hard to distinguish: with both in the model they are {texts[0]} and "
        f"{texts[1]} (95 %), and their errors correlate by {rho:+.2f}."
    )
