"""A search for a shape that ends at the end of the plausible range has found no shape."""

from dataclasses import replace

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.dynamics.effects.base import Quantity


def reason(before: FittedModel, after: FittedModel, index: int) -> str | None:
    """Say whether a shape stopped at a limit that is not physical, and held-out rows confirm it there."""
    quantities, structure = after.terms[index].shapes, after.solution.structure
    entries = np.flatnonzero(structure.parameter_mask(index))
    for entry, shape in zip(entries[len(entries) - len(quantities) :].tolist(), quantities, strict=True):
        value = after.solution.x[entry]
        at_limit = (shape.implausible_bound == "upper" and value >= shape.upper) or (
            shape.implausible_bound == "lower" and value <= shape.lower
        )
        if at_limit and _is_needed_at_limit(after, index, entry, shape):
            return f"the search for its {shape.name} ended at the end of the plausible range"
    return None


def _is_needed_at_limit(model: FittedModel, index: int, entry: int, shape: Quantity) -> bool:
    """Whether held-out rows confirm a `shape` of the term `index` at its limit over the nearest initial guess."""
    if not shape.initial_guesses:
        return True
    effect, x = model.terms[index].effect, model.solution.x.copy()
    x[entry] = min(shape.initial_guesses, key=lambda guess: abs(guess - x[entry]))
    shapes = tuple(replace(each, searched=False) if each.name == shape.name else each for each in effect.shapes)
    structure = model.solution.structure.with_effect(index, effect.changed(shapes=shapes))
    return model.improvement_over(FittedModel(model.split, model.split.fit(structure, x))).is_supported
