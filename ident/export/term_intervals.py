"""The interval that the parameters' uncertainty leaves to the RMS of each cause of the torque."""

from collections.abc import Mapping

import numpy as np

from ident.dynamics.inverse_dynamics import InverseDynamics
from ident.export.paths import PathChunk
from ident.identification.model import Model
from recordings.recording import Floats

_STEP = 1e-3
"""Relative finite-difference step of a parameter without interval."""
_TINY = 1e-12
"""RMS of a cause that is absent [N m]."""


def relative_half_widths(model: Model, chunk: PathChunk) -> dict[str, Floats] | None:
    """Half width (dof,) of the 95 % interval of each cause's RMS, and of the "torque", over that RMS.

    To first order in the errors of the parameters, with their correlation, for an exactly known torque gain. NaN
    where a parameter that matters has no interval; None if the model has no assessment.
    """
    covariance = _covariance(model)
    if covariance is None:
        return None
    dynamics, entries = model.dynamics, np.flatnonzero(model.dynamics.structure.linear)
    rms = _rms(dynamics, chunk)
    gradients: dict[str, list[Floats]] = {name: [] for name in rms}
    for entry, width in zip(entries, np.sqrt(np.diag(covariance)), strict=True):
        step = width if width > 0 else _STEP * max(abs(dynamics.values[entry]), _STEP)
        values = dynamics.values.copy()
        values[entry] += step
        shifted = _rms(InverseDynamics(dynamics.structure, values), chunk)
        for name, of_shifted in shifted.items():
            gradients[name].append((of_shifted - rms[name]) / step)
    widths = {name: _half_width(np.array(rows), covariance) for name, rows in gradients.items()}
    return {name: width / np.maximum(rms[name], _TINY) for name, width in widths.items()}


def _covariance(model: Model) -> Floats | None:
    """Covariance (K, K) of the parameters in half widths of their intervals; NaN where one has none."""
    assessment, parameters = model.file.assessment, model.file.parameters
    if assessment is None or len(assessment.correlation) < len(parameters):
        return None
    intervals = [parameter.shape_ci95 or (np.nan, np.nan) for parameter in parameters]
    widths = np.diff(np.array(intervals), axis=1)[:, 0] / 2
    correlation = np.array([[np.nan if x is None else x for x in row] for row in assessment.correlation])
    return correlation[: len(widths), : len(widths)] * np.outer(widths, widths)


def _rms(dynamics: InverseDynamics, chunk: PathChunk) -> Mapping[str, Floats]:
    """RMS (dof,) of each cause and of the torque."""
    terms = dynamics.terms_with_corrections(chunk.inputs_of)
    terms["torque"] = np.sum(list(terms.values()), axis=0)
    return {name: np.sqrt(np.nanmean(values[chunk.used] ** 2, axis=0)) for name, values in terms.items()}


def _half_width(gradient: Floats, covariance: Floats) -> Floats:
    """Half width (dof,) from the `gradient` (K, dof); parameters that do not matter need no interval."""
    result = np.empty(gradient.shape[1])
    for joint, slope in enumerate(gradient.T):
        matters = np.abs(slope) > 0
        result[joint] = np.sqrt(max(slope[matters] @ covariance[np.ix_(matters, matters)] @ slope[matters], 0.0))
    return result
