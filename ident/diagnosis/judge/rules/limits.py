"""Coefficients have the sign and the size that the effect declares."""

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.dynamics.structure import Term
from recordings.recording import Floats


def reason(before: FittedModel, after: FittedModel, index: int) -> str | None:
    """Say whether a strength is outside of its physical limits."""
    local = after.solution.structure.local_values(index, after.solution.x)
    if all(possible_instances(after.terms[index], local)):
        return None
    return "it would need a size or a sign that is not possible"


def possible_instances(term: Term, local: Floats) -> list[bool]:
    """For each instance of `term`, whether its parameters `local` (instances, c) are within their physical limits."""
    lower, upper = (
        np.array([getattr(quantity, side) for quantity in term.local_parameters]) for side in ("lower", "upper")
    )
    return [bool(((lower <= row) & (row <= upper)).all()) for row in local]
