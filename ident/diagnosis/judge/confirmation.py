"""The rule when an effect counts as confirmed: what test rows, which no fit uses, must show."""

from ident.diagnosis.judge.improvement import Improvement

MIN_T = 3.5
"""Student's t from which a test improvement is supported; it is high because many candidates are tried."""
MIN_LOWER_BOUND = 0.1
"""Lower bound of the interval from which a test improvement is supported as well."""
MIN_DECISIVE_SHARE = 0.5
"""An improvement over an equivalent model is decisive if it removes this share of its excess error. An effect that
removes it on training rows is not small."""
MIN_DECISIVE_REDUCTION = 0.05
"""Smaller reductions of the mean square, in units of the squared noise floor, are never decisive: the floor is not
known more accurately."""


def is_supported(improvement: Improvement) -> bool:
    """Whether the test rows support an improvement: a small one in most blocks, or a large one in a few.

    In a few short blocks of very different size, the ratio of the errors tells what their difference does not.
    """
    large = improvement.share > MIN_DECISIVE_SHARE and improvement.t_of_ratio > MIN_T
    any_size = max(improvement.t_statistic, improvement.t_for_change) > MIN_T
    return any_size or improvement.interval[0] > MIN_LOWER_BOUND or large


def is_structure(improvement: Improvement) -> bool:
    """Whether the test rows show that what a curve explains is no noise, even if the noise floor is unknown."""
    return is_supported(improvement) or improvement.t_of_ratio > MIN_T


def is_decisive(improvement: Improvement) -> bool:
    """Whether an improvement rules out a model that explains nearly as much."""
    return (
        improvement.t_statistic > MIN_T
        and improvement.share > MIN_DECISIVE_SHARE
        and improvement.reduction > MIN_DECISIVE_REDUCTION
    )
