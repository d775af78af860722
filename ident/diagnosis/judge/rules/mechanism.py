"""Parameters that were possible stay so: no friction that drives, no spring that pushes away from its rest."""

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import MIN_SHARE, MIN_T
from recordings.recording import Bools


def reason(before: FittedModel, after: FittedModel, index: int) -> str | None:
    """Say which parameter of the mechanism is not possible beside the effect.

    It is one that the effect makes negative, or that of a joint on which a friction law stands beside friction that
    drives.
    """
    parameters = after.solution.structure.mechanism.parameters
    flipped = _impossible(after, index) & (before.solution.x[: len(parameters)] >= 0)
    if flipped.any():
        return f"{parameters[int(np.argmax(flipped))].name} would get a value that is not possible"
    if driven := driven_joints(after, index):
        return f"the friction of joint {driven[0] + 1} beside it would drive the motion"
    return None


def driven_joints(model: FittedModel, index: int) -> tuple[int, ...]:
    """Joints (from 0) on which the effect `index` is a law of friction, and the rest of their friction drives."""
    term, names = model.terms[index], [each.name for each in model.solution.structure.mechanism.parameters]
    if not term.effect.depends_on_speed:
        return ()
    negative = {name for name, each in zip(names, _impossible(model, index), strict=True) if each}
    return tuple(joint for joint in term.joints if negative & {f"c_v{joint + 1}", f"c_c{joint + 1}"})


def _impossible(model: FittedModel, index: int) -> Bools:
    """(k,) which parameters of the mechanism that physics makes positive are not.

    While much is missing, one may be negative by chance, or where its torque is negligible beside that of the effect.
    """
    structure, x = model.solution.structure, model.solution.x
    parameters = structure.mechanism.parameters
    count = len(parameters)
    negative = np.array([parameter.physically_positive for parameter in parameters]) & (x[:count] < 0)
    if negative.any():
        negative &= ~(x[:count] > -MIN_T * model.uncertainty.std[:count])  # refused where the error is not known
        torques = model.solution.rows()[0] * x
        of_effect = torques[:, structure.parameter_mask(index) & structure.linear].sum(axis=1)
        negative &= np.linalg.norm(torques[:, :count], axis=0) > MIN_SHARE * np.linalg.norm(of_effect)
    return negative
