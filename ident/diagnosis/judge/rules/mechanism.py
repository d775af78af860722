"""Parameters that were possible stay so: no friction that drives, no spring that pushes away from its rest."""

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import MIN_T
from recordings.recording import Floats

_SIGN_TOLERANCE = 0.1
"""A positive parameter may become negative by this share of its former value by chance."""
_MINOR_SHARE = 0.2
"""Torque of a negative parameter, relative to that of the effect that made it so, below which it is no objection."""


def reason(before: FittedModel, after: FittedModel, index: int) -> str | None:
    """Say which parameter of the mechanism the effect makes impossible."""
    flipped = _flipped_parameter(before, after, index)
    return f"{flipped} would get a value that is not possible" if flipped else None


def _flipped_parameter(before: FittedModel, model: FittedModel, index: int) -> str | None:
    """Name of a positive parameter of the mechanism that `model` makes negative and that was not so `before`.

    An example is friction that drives the motion. While much is missing, a parameter may be negative by chance, or
    where its torque is small beside that of the effect `index`.
    """
    parameters = model.solution.structure.mechanism.parameters
    positive = np.array([parameter.physically_positive for parameter in parameters])
    now, then = (fitted.solution.x[: len(parameters)] for fitted in (model, before))
    flipped = positive & (then >= 0) & (now < -_SIGN_TOLERANCE * np.abs(then))
    if flipped.any():
        error = model.uncertainty.std[: len(parameters)]
        flipped &= ~(now > -MIN_T * error)  # refused where the error is not known
        flipped &= _torque_sizes(model)[: len(parameters)] > _MINOR_SHARE * _term_torque(model, index)
    return parameters[int(np.argmax(flipped))].name if flipped.any() else None


def _torque_sizes(model: FittedModel) -> Floats:
    """(K,) weighted RMS torque of each parameter times its derivative, up to a common factor."""
    regressor, _ = model.solution.rows()
    sizes: Floats = np.sqrt((regressor**2).sum(axis=0)) * np.abs(model.solution.x)
    return sizes


def _term_torque(model: FittedModel, index: int) -> float:
    """The same for all linear coefficients of the term `index` together; 0 if it has none."""
    structure = model.solution.structure
    linear = structure.parameter_mask(index) & structure.linear
    return float(np.linalg.norm(model.solution.rows()[0][:, linear] @ model.solution.x[linear]))
