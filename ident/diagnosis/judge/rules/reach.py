"""Recordings that are too short, slow or narrow show no time constants, limits and waves; transients no warmth."""

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.dynamics.torque_map import voltage_from_torque


def reason(before: FittedModel, after: FittedModel, index: int) -> str | None:
    """Say which time constant, limit or wave is beyond the recordings."""
    term, model = after.terms[index], after
    shapes = model.solution.structure.shape_values(index, model.solution.x)
    longest = max(float(each.prepared.time[-1] - each.prepared.time[0]) for each in model.split.train_predictors)
    for shape, value in zip(term.shapes, shapes, strict=True):
        if shape.max_durations is not None and abs(value) > shape.max_durations * longest:
            return f"its {shape.name} of {value:.3g} {shape.unit} is far longer than the recording of {longest:.3g} s"
        if abs(value) < shape.least:
            return f"its {shape.name} of {value:.3g} {shape.unit} is shorter than the {shape.least:g} s that it takes"
    for column, quantity in enumerate(term.local_parameters):
        if quantity.min_use is not None and _largest_use(model, index, column) < quantity.min_use:
            return "the level that it would need was never approached"
    wave = max((2 * np.pi / value for value in shapes if value > 0), default=0.0)  # of the line of a spectrum
    if term.effect.repeated and wave > (travel := float(model.split.travel[list(term.joints)].max())):
        return (
            f"its period of {wave:.3g} is longer than the travel of {travel:.3g}: a curve over the angle, no ripple"
        )
    return None


def _largest_use(model: FittedModel, index: int, column: int) -> float:
    """Largest product of the parameter `column` of the term `index` and the voltage, over joints and recordings.

    Those that are held out count as well: where they approach a level that the others only point to, they judge it.
    """
    joints, local = list(model.terms[index].joints), model.solution.structure.local_values(index, model.solution.x)
    largest = [
        np.nanmax(np.abs(voltage_from_torque(each.torque, each.recording.rig.torque))[:, joints], axis=0)
        for each in model.split.recordings
    ]
    return float((np.max(largest, axis=0) * local[:, column]).max())
