"""What held-out rows, which no fit uses, must show of an improvement."""

from ident.diagnosis.judge.improvement import Improvement

MIN_T = 3.5
"""Student's t that confirms an improvement on held-out rows; it is high because many models are tried."""
MIN_SHARE = 0.1
"""Share of the mean square above the noise floor that an effect must take: with much data, trifles are
significant."""


def strongest_t(improvement: Improvement) -> float:
    """The largest Student's t of an improvement.

    Of the mean squares over all blocks, or over those that the change concerns; and of the logarithms of their ratio,
    which no block outweighs, where the improvement is no trifle.
    """
    of_ratio = 0.0 if is_small(improvement) else improvement.t_of_ratio
    return max(improvement.t_statistic, improvement.t_for_change, of_ratio)


def is_supported(improvement: Improvement) -> bool:
    """Whether held-out rows confirm an improvement."""
    return strongest_t(improvement) > MIN_T


def is_small(improvement: Improvement) -> bool:
    """Whether an improvement takes less than MIN_SHARE of what is left above the noise floor."""
    return improvement.reduction < MIN_SHARE * (improvement.remaining + improvement.reduction)
