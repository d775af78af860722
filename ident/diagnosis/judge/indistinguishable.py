"""Effects that the motion hardly distinguishes: only their sum is known."""

from itertools import combinations

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel

MAX_CORRELATION = 0.95
"""Parameters whose errors correlate by more are known only together: each variance is ten times what it would be
without the other (variance inflation factor)."""


def indistinguishable(model: FittedModel) -> list[tuple[int, int, float]]:
    """Pairs of coefficients of two effects, as entries of the parameters, with the correlation of their errors."""
    entries = [(i, entry) for i, entry in enumerate(model.solution.structure.parameters) if is_strength(model, i)]
    if len(entries) < 2:
        return []
    correlation = model.uncertainty.correlation
    return [
        (i, j, float(correlation[i, j]))
        for (i, first), (j, second) in combinations(entries, 2)
        if first.term != second.term and np.abs(correlation[i, j]) > MAX_CORRELATION
    ]


def is_strength(model: FittedModel, entry: int) -> bool:
    """Whether the entry is a linear coefficient of an effect that could be a finding."""
    parameter = model.solution.structure.parameters[entry]
    return parameter.term >= 0 and parameter.linear and not model.terms[parameter.term].effect.mandatory
