"""Coefficients have the sign and the size that the effect declares.

More than hardware usually has is not impossible: it has a price (`judge.price`), and a warning.
"""

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.dynamics.structure import Term
from recordings.recording import Bools, Floats


def reason(before: FittedModel, after: FittedModel, index: int) -> str | None:
    """Say whether a strength is outside of its physical limits."""
    term, local = after.terms[index], after.solution.structure.local_values(index, after.solution.x)
    return None if _possible(term, local).all() else "it would need a size or a sign that is not possible"


def plausible_instances(term: Term, local: Floats) -> list[bool]:
    """For each instance of `term`, whether its parameters `local` (instances, c) are possible and plausibly small."""
    plausible: list[bool] = (_possible(term, local) & ~_extraordinary(term, local)).tolist()
    return plausible


def extraordinary_joints(model: FittedModel, index: int) -> list[int]:
    """Joints (from 0) on which the effect `index` of `model` is larger than hardware usually has."""
    term, local = model.terms[index], model.solution.structure.local_values(index, model.solution.x)
    return [joint for joint, large in zip(term.joints, _extraordinary(term, local), strict=False) if large]


def _possible(term: Term, local: Floats) -> Bools:
    """(instances,) whether all parameters `local` (instances, c) are within their physical limits."""
    lower, upper = ([getattr(quantity, side) for quantity in term.local_parameters] for side in ("lower", "upper"))
    return np.asarray(((np.array(lower) <= local) & (local <= np.array(upper))).all(axis=1))


def _extraordinary(term: Term, local: Floats) -> Bools:
    """(instances,) whether the parameters `local` (instances, c) are larger than hardware usually has."""
    limit = term.effect.max_amplitude
    return np.asarray(np.linalg.norm(local, axis=1) > (np.inf if limit is None else limit))
