"""What parameters cost, which of two models the data prefer at that price, and which they cannot tell apart."""

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import Improvement
from ident.diagnosis.judge.rules.limits import extraordinary_joints
from ident.diagnosis.split.split_data import TINY, rms
from recordings.recording import Floats

PRICE = 15.0
"""Price of a parameter: times what it gains by fitting noise, which is 1 in n ln(mean square)."""
EXTRAORDINARY_RATIO = 5.0
"""A strength that hardware seldom has is believed only where all else leaves this many times its mean square."""
EQUIVALENT_SHARE = 0.04
"""Models whose reductions of the loss differ by less than this share are equivalent."""
MIN_DECISIVE_SHARE = 0.5
"""An improvement over an equivalent model is decisive if it removes this share of its excess error."""
MIN_DECISIVE_REDUCTION = 0.05
"""Smaller reductions of the mean square, in units of the squared noise floor, are never decisive: the floor is not
known more accurately."""


def is_significant(before: float, after: float, parameters: int, independent_rows: float) -> bool:
    """Whether a loss falls from `before` to `after` by more than so many `parameters` are worth."""
    return before - after > PRICE * parameters * (after / independent_rows)


def score(model: FittedModel) -> float:
    """What a `model` leaves at its price, and what is seldom at its own: the smaller of two is the better model.

    A strength that hardware seldom has costs as much as it must explain (`EXTRAORDINARY_RATIO`): a prior.
    """
    joints = [joint for index in range(len(model.terms)) for joint in extraordinary_joints(model, index)]
    prior = float(np.log(EXTRAORDINARY_RATIO) * model.split.independent(model.split.scored)[joints].sum())
    return likelihood_score(model, model.noise_floor.certain) + prior


def likelihood_score(model: FittedModel, floor: Floats) -> float:
    """Sum n ln(mean square) of training and held-out rows over all joints, plus the price of the parameters.

    floor: (dof,) noise floor [N m]. No joint gains by an error below it: what is fitted there is noise.
    """
    loss = 0.0
    for rows in (model.split.train, model.split.test):
        error = np.maximum(np.maximum(rms(model.judged_residuals, rows), floor), TINY)
        loss += float((model.split.independent(rows) * 2 * np.log(error)).sum())
    return loss + PRICE * sum(entry.free for entry in model.solution.structure.parameters)


def slack(before: float, best: float, independent_rows: float) -> float:
    """Loss by which a model may exceed the `best` one and be equivalent; `before`: without either effect."""
    return max(EQUIVALENT_SHARE * (before - best), PRICE * (best / independent_rows))


def is_decisive(improvement: Improvement) -> bool:
    """Whether an improvement rules out a model that explains nearly as much."""
    return (
        improvement.is_supported
        and improvement.share > MIN_DECISIVE_SHARE
        and improvement.reduction > MIN_DECISIVE_REDUCTION
    )


def is_preferred(model: FittedModel, alternative: FittedModel) -> bool:
    """Whether the data prefer `model` to an `alternative` that explains nearly as much.

    Either the held-out rows are decisive, or all rows are, because the motion that tells them apart may be in the
    training rows. In the latter case the improvement must exceed what extra parameters gain by fitting noise.
    """
    if is_decisive(model.improvement_over(alternative)):
        return True
    better, other = model.solution, alternative.solution
    parameters = max(len(better.x) - len(other.x), 1)
    return is_significant(other.loss, better.loss, parameters, model.split.independent_rows) and is_decisive(
        model.improvement_over(alternative, model.split.scored)
    )
