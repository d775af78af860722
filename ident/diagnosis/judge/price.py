"""What parameters cost: by how much a loss must fall before it is more than the fitting of noise."""

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.rules.limits import extraordinary_joints
from ident.diagnosis.split.split_data import TINY, rms

PRICE = 15.0
"""Price of a parameter: times what it gains by fitting noise, which is 1 in n ln(mean square)."""
EXTRAORDINARY_RATIO = 5.0
"""A strength that hardware seldom has is believed only where all else leaves this many times its mean square."""


def chance_reduction(loss: float, independent_rows: float) -> float:
    """Reduction of the `loss` that one more parameter gains by fitting noise."""
    return loss / independent_rows


def is_significant(before: float, after: float, parameters: int, independent_rows: float) -> bool:
    """Whether a loss falls from `before` to `after` by more than so many `parameters` are worth."""
    return before - after > PRICE * parameters * chance_reduction(after, independent_rows)


def score(model: FittedModel) -> float:
    """Sum n ln(mean square) of training and held-out rows over all joints, plus the price of the parameters.

    The smaller of two is the better model. No joint gains by an error below its noise floor: what is fitted there is
    noise. A strength that hardware seldom has costs as much as it must explain (`EXTRAORDINARY_RATIO`): a prior.
    """
    floor = model.noise_floor.certain
    loss = 0.0
    for rows in (model.split.train, model.split.test):
        error = np.maximum(np.maximum(rms(model.judged_residuals, rows), floor), TINY)
        loss += float((model.split.independent(rows) * 2 * np.log(error)).sum())
    return loss + PRICE * sum(entry.free for entry in model.solution.structure.parameters) + _prior(model)


def _prior(model: FittedModel) -> float:
    joints = [joint for index in range(len(model.terms)) for joint in extraordinary_joints(model, index)]
    rows = model.split.independent(model.split.scored)
    return float(np.log(EXTRAORDINARY_RATIO) * rows[joints].sum())
