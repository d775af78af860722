"""Which of two explanations the data prefer, and which they cannot tell apart."""

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import Improvement
from ident.diagnosis.judge.price import PRICE, chance_reduction, is_significant

EQUIVALENT_SHARE = 0.04
"""Models whose reductions of the loss differ by less than this share are equivalent."""
MIN_DECISIVE_SHARE = 0.5
"""An improvement over an equivalent model is decisive if it removes this share of its excess error."""
MIN_DECISIVE_REDUCTION = 0.05
"""Smaller reductions of the mean square, in units of the squared noise floor, are never decisive: the floor is not
known more accurately."""


def slack(before: float, best: float, independent_rows: float) -> float:
    """Loss by which a model may exceed the `best` one and be equivalent; `before`: without either effect."""
    return max(EQUIVALENT_SHARE * (before - best), PRICE * chance_reduction(best, independent_rows))


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
    parameters = max(len(model.solution.x) - len(alternative.solution.x), 1)
    losses = alternative.solution.loss, model.solution.loss
    if not is_significant(*losses, parameters, model.split.independent_rows):
        return False
    return is_decisive(model.improvement_over(alternative, model.split.scored))
