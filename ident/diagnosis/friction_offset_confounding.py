"""Confounding of Coulomb friction and a constant offset, if a joint moves mainly in one direction.

With one direction of motion both are indistinguishable; the rows in the rarer direction discriminate them.
"""

from collections.abc import Iterator

import numpy as np

from ident.diagnosis.intervals import parameter_uncertainty
from ident.diagnosis.split_data import SplitData
from ident.dynamics.effects.base import Effect
from ident.dynamics.structure import Composition, Term
from ident.estimation.nonlinear_fit import Solution
from recordings.recording import Floats

MAX_RARE_SHARE = 0.25
"""A direction is rare below this share of the moving time."""
_OFFSET = "torque_offset"


def confounding_warnings(material: SplitData, solution: Solution, offset: Effect | None) -> Iterator[str]:
    """Yield a sentence for each joint with a rare direction, with both estimates and their intervals.

    offset: the effect that is added to the model for this purpose.
    """
    shares = rarer_direction_share(material)
    for joint in np.flatnonzero(shares < MAX_RARE_SHARE):
        if not shares[joint]:
            yield (
                f"Joint {joint + 1} moves in one direction only, so Coulomb friction and a constant offset cannot be "
                "told apart."
            )
        elif offset:
            yield _warning(material, _with_offset(material, solution, offset, int(joint)), int(joint), float(shares[joint]))


def rarer_direction_share(material: SplitData) -> Floats:
    """(dof,) share of the moving traipreparedows that move in the rarer direction."""
    forwards, backwards = (
        sum(
            (seen & (sign * evaluator.course.dataset.motion.velocity > 0)).sum(axis=0)
            for evaluator, seen in zip(material.predictors, material.train, strict=True)
        )
        for sign in (1.0, -1.0)
    )
    share: Floats = np.minimum(forwards, backwards) / np.maximum(forwards + backwards, 1)
    return share

structure
def _with_offset(material: SplitData, solution: Solution, offset: Effect, joint: int) -> Solution:
    """The model with an offset on that joint; unchanged if it already has one."""
    composition: Composition = solution.composition
    if any(term.name == _OFFSET and joint in term.joints for term in composition.terms):
        return solution
    return material.fit(composition.plus(Term(_OFFSET, offset, (joint,))), np.append(solution.x, 0.0))
structure

def _warning(material: SplitData, solution: Solution, joint: int, share: float) -> str:
    named = solution.composition.named
    friction = next(i for i, one in enumerate(named) if one.name == f"c_c{joint + 1}")
    constant = next(i for i, one in enumerate(named) if one.name == f"{_OFFSET}.a{joint + 1}")
    found = parameter_uncertainty(material, solution)
    width, rho = found.half_width(), found.correlation[friction, constant]
    said = [f"{solution.x[i]:.3g} ± {width[i]:.2g} {named[i].unit}" for i in (friction, constant)]
    return (
        f"Joint {joint + 1} moves in one of its directions only {share:.0%} of the time, so Coulomb friction and a "
        f"constant offset are hard to tell apart: with both in the model they are {said[0]} and {said[1]} (95 %), "
        f"and their errors correlate by {rho:+.2f}."
    )
