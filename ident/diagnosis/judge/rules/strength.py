"""The data determine the strength: its interval does not hold zero."""

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.uncertainty.covariance import LEVEL
from recordings.recording import Floats, Ints

_MAX_LINE_WIDTH = 0.05
"""Largest half-width of the interval of a line's order, relative to it: a line is narrow."""


def reason(before: FittedModel, after: FittedModel, index: int) -> str | None:
    """Say whether no strength differs from zero, the sign of a time constant is open, or signs contradict."""
    if not any(resolved_instances(after, index)):
        return "its strength is zero within its interval"
    term, structure = after.terms[index], after.solution.structure
    half_width, entries = after.uncertainty.half_width(), np.flatnonzero(structure.parameter_mask(index))
    shape_entries = entries[len(entries) - len(term.shapes) :]
    for entry, shape in zip(shape_entries.tolist(), term.shapes, strict=True):
        if shape.max_durations is not None and abs(after.solution.x[entry]) < half_width[entry]:
            return f"its {shape.name} is zero within its interval"
        if term.effect.repeated and half_width[entry] > _MAX_LINE_WIDTH * abs(after.solution.x[entry]):
            return f"its {shape.name} is not determined: a piece of a curve, no line"
    if term.effect.same_sign:
        local = structure.local_values(index, after.solution.x)
        width = half_width[local_entries(after, index)]
        if ((local > width).any(axis=1) & (local < -width).any(axis=1)).any():
            return "its parts would need opposite signs"
    return None


def resolved_instances(model: FittedModel, index: int) -> list[bool]:
    """For each instance of the term `index`, whether its local parameters together differ from zero.

    What repeats with the motion counts as in the intervals that are reported: no effect is named on a joint beside an
    interval that holds zero.
    """
    from scipy.special import chdtri

    covariance = model.uncertainty.covariance + model.propagated_covariance
    local = model.solution.structure.local_values(index, model.solution.x)
    instances = zip(local, local_entries(model, index), strict=True)
    limit = chdtri(local.shape[1], 1 - LEVEL)
    return [bool(wald_statistic(values, covariance, entries) > limit) for values, entries in instances]


def local_entries(model: FittedModel, index: int) -> Ints:
    """(instances, c) entries of the local parameters of the term `index` in the parameter vector."""
    index %= len(model.terms)
    shape = model.solution.structure.local_values(index, model.solution.x).shape
    entries = np.flatnonzero(model.solution.structure.parameter_mask(index))
    return entries[: shape[0] * shape[1]].reshape(shape)


def wald_statistic(values: Floats, covariance: Floats, entries: Ints) -> float:
    """Wald's statistic of the parameters `values` (c,), the `entries` of a `covariance` (K, K); 0 where not known."""
    own = covariance[np.ix_(entries, entries)]
    known = np.isfinite(np.diag(own))
    return float(values[known] @ np.linalg.pinv(own[np.ix_(known, known)]) @ values[known])
