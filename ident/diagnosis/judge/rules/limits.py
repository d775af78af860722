"""Coefficients have the sign and the size that the effect declares.

More than hardware usually has is not impossible: it has a price (`judge.price`), and a warning.
"""

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import MIN_T
from ident.diagnosis.judge.rules.strength import local_entries
from ident.diagnosis.split.split_data import rms
from ident.dynamics.structure import Term
from recordings.recording import Bools, Floats


def reason(before: FittedModel, after: FittedModel, index: int) -> str | None:
    """Say whether a strength is outside of its physical limits."""
    return None if _possible_in(after, index).all() else "it would need a size or a sign that is not possible"


def plausible_instances(term: Term, local: Floats) -> list[bool]:
    """For each instance of `term`, whether its parameters `local` (instances, c) are possible and plausibly small."""
    return (_within(term, local).all(axis=1) & ~_extraordinary(term, local)).tolist()


def plausible_joints(model: FittedModel, index: int) -> tuple[int, ...]:
    """Joints (from 0) on which the effect `index` of `model` is possible and plausibly small."""
    term, local = model.terms[index], model.solution.structure.local_values(index, model.solution.x)
    plausible = _possible_in(model, index) & ~_extraordinary(term, local)
    return tuple(joint for joint, inside in zip(term.joints, plausible, strict=False) if inside)


def extraordinary_joints(model: FittedModel, index: int) -> list[int]:
    """Joints (from 0) on which the effect `index` of `model` is what hardware seldom has.

    Its amplitude or one of its parameters is larger than usual, or its travel; or it gives more torque than the drive
    does, so that other parameters have to balance it.
    """
    term, local = model.terms[index], model.solution.structure.local_values(index, model.solution.x)
    usual = np.array([quantity.usual_range for quantity in term.local_parameters])
    seldom = _extraordinary(term, local) | ((local < usual[:, 0]) | (local > usual[:, 1])).any(axis=1)
    joints = [joint for joint, unusual in zip(term.joints, seldom, strict=False) if unusual]
    if term.effect.whole_robot:
        return joints
    far, large = model.split.travel > term.effect.usual_travel, _torque(model, index) > model.split.torque_rms
    return sorted({*joints, *(joint for joint in term.joints if far[joint] or large[joint])})


def _torque(model: FittedModel, index: int) -> Floats:
    """(dof,) RMS torque of the linear effect `index` in the training rows [N m]; 0 of one that distorts signals."""
    structure, solution = model.solution.structure, model.solution
    own = structure.parameter_mask(index) & structure.linear
    torques = [derivatives[:, :, own] @ solution.x[own] for derivatives in solution.derivatives]
    return rms(torques, [weight > 0 for weight in solution.weights])


def _possible_in(model: FittedModel, index: int) -> Bools:
    """(instances,) whether the parameters of the effect `index` of `model` are within their physical limits.

    Beside one that is, another with limits may lie beyond them by its error: a second coefficient that is zero.
    """
    term, local = model.terms[index], model.solution.structure.local_values(index, model.solution.x)
    within, limited = _within(term, local), [np.isfinite([q.lower, q.upper]).any() for q in term.local_parameters]
    possible, one = within.all(axis=1), (within & limited).any(axis=1)
    if (one & ~possible).any():
        errors = model.standard_errors[local_entries(model, index)]
        possible |= one & _within(term, local, MIN_T * errors).all(axis=1)
    return np.asarray(possible)


def _within(term: Term, local: Floats, slack: Floats | float = 0.0) -> Bools:
    """(instances, c) whether each parameter `local` (instances, c) is within its physical limits, but for `slack`."""
    lower, upper = ([getattr(quantity, side) for quantity in term.local_parameters] for side in ("lower", "upper"))
    return np.asarray((np.array(lower) - slack <= local) & (local <= np.array(upper) + slack))


def _extraordinary(term: Term, local: Floats) -> Bools:
    """(instances,) whether the parameters `local` (instances, c) are larger than hardware usually has."""
    limit = term.effect.max_amplitude
    return np.asarray(np.linalg.norm(local, axis=1) > (np.inf if limit is None else limit))
