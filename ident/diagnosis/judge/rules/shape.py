"""A search for a shape that ends at the end of the plausible range has found no shape."""

from dataclasses import replace

import numpy as np

from ident.diagnosis.judge.confirmation import is_supported
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.dynamics.effects.base import Quantity

MIN_SHAPE_EFFECT = 0.01
"""A shape parameter is identifiable if moving it across its range changes the residual by more than this share of the
remaining loss, in squares."""


def reason(before: FittedModel, after: FittedModel, index: int) -> str | None:
    """Say whether a shape stopped at a limit that is not physical, and held-out rows confirm it there."""
    quantities, structure = after.terms[index].shapes, after.solution.structure
    values = structure.shape_values(index, after.solution.x)
    entries = np.flatnonzero(structure.parameter_mask(index))[-len(values) :].tolist() if len(values) else []
    at_limit = any(
        (
            (shape.implausible_bound == "upper" and value >= shape.upper)
            or (shape.implausible_bound == "lower" and value <= shape.lower)
        )
        and _is_identifiable(after, entry, shape.upper - shape.lower)
        and _is_needed_at_limit(after, index, entry, shape)
        for entry, shape, value in zip(entries, quantities, values, strict=True)
    )
    return "the search for its shape ended at the end of the plausible range" if at_limit else None


def _is_identifiable(model: FittedModel, entry: int, span: float) -> bool:
    """Whether the loss depends on entry `entry` of the parameter vector anywhere in its range `span`."""
    pairs = zip(model.solution.weights, model.solution.derivatives, strict=True)
    changed = sum(float(np.nansum((weight * by_x[:, :, entry] * span) ** 2)) for weight, by_x in pairs)
    return changed > MIN_SHAPE_EFFECT * model.solution.loss


def _is_needed_at_limit(model: FittedModel, index: int, entry: int, shape: Quantity) -> bool:
    """Whether test rows confirm a `shape` of the term `index` at its limit over the nearest initial guess, if any."""
    if not shape.initial_guesses:
        return True
    effect, x = model.terms[index].effect, model.solution.x.copy()
    x[entry] = min(shape.initial_guesses, key=lambda guess: abs(guess - x[entry]))
    shapes = tuple(replace(each, searched=False) if each.name == shape.name else each for each in effect.shapes)
    structure = model.solution.structure.with_effect(index, replace(effect, shapes=shapes))
    return is_supported(model.improvement_over(FittedModel(model.split, model.split.fit(structure, x))))
