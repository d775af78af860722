"""Parameters that were possible stay so: no friction that drives, no spring that pushes away from its rest."""

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import MIN_SHARE, MIN_T


def reason(before: FittedModel, after: FittedModel, index: int) -> str | None:
    """Say which positive parameter of the mechanism, that was not so `before`, the effect makes negative.

    An example is friction that drives the motion. While much is missing, a parameter may be negative by chance, or
    where its torque is a trifle beside that of the effect.
    """
    structure, x = after.solution.structure, after.solution.x
    parameters = structure.mechanism.parameters
    count = len(parameters)
    positive = np.array([parameter.physically_positive for parameter in parameters])
    flipped = positive & (before.solution.x[:count] >= 0) & (x[:count] < 0)
    if not flipped.any():
        return None
    flipped &= ~(x[:count] > -MIN_T * after.uncertainty.std[:count])  # refused where the error is not known
    torques = after.solution.rows()[0] * x
    of_effect = torques[:, structure.parameter_mask(index) & structure.linear].sum(axis=1)
    flipped &= np.linalg.norm(torques[:, :count], axis=0) > MIN_SHARE * np.linalg.norm(of_effect)
    return (
        f"{parameters[int(np.argmax(flipped))].name} would get a value that is not possible"
        if flipped.any()
        else None
    )
