"""Rules of plausibility: each says why one effect of a model cannot be true, or None; the cheap ones first.

A rule is one file with a function `reason(before, after, index)`: `after` is the model with the effect number
`index`, `before` the one without it. A reason ends the sentence "It would explain 12 % of what is left, but …".
"""

from collections.abc import Callable

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.rules import limits, mechanism, reach, shape, simpler, strength

Rule = Callable[[FittedModel, FittedModel, int], str | None]

OF_VALUES: dict[str, Rule] = {
    "limits": limits.reason,
    "mechanism": mechanism.reason,
    "reach": reach.reason,
    "shape": shape.reason,
}
"""What the fitted values themselves forbid, by name."""
OF_INTERVALS: dict[str, Rule] = {"simpler": simpler.reason, "strength": strength.reason}
"""What the intervals of the values leave open, by name; they cost more."""


def objection(rules: dict[str, Rule], before: FittedModel, after: FittedModel, index: int) -> tuple[str, str] | None:
    """Name of the first of the `rules` that the effect `index` of `after` breaks, and the reason; or None."""
    for name, rule in rules.items():
        if reason := rule(before, after, index):
            return name, reason
    return None
