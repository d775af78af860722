"""Warn where held-out recordings leave the range of the training data and the model fails there.

An effect that occurs only outside of that range, such as backlash without load reversal or saturation that was never
reached, cannot be identified from the training data. The error in those rows is no evidence against the model.
"""

from collections.abc import Iterator

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.split.split_data import SplitData, rms
from ident.diagnosis.split.training_range import outside_of_range, training_range

_MIN_BLAME = 0.7
"""Share by which the error above the noise floor must be smaller in the rows inside of the range than in all rows."""


def extrapolation_warnings(split: SplitData, model: FittedModel) -> Iterator[str]:
    """Yield a sentence for each joint whose held-out error is above the noise mostly out of the range of training."""
    floor, rig = model.noise_floor, split.recordings[0].recording.rig
    scored, residual = (np.concatenate(parts) for parts in (split.test, model.residuals))
    quantities = {
        "torque": ([data.torque for data in split.recordings], rig.effort_units),
        "speed": ([data.motion.velocity for data in split.recordings], [f"{unit}/s" for unit in rig.position_units]),
        "position": ([data.motion.position for data in split.recordings], rig.position_units),
    }
    failed = split.other_motion & (rms(model.residuals, split.test) > floor.limit)
    for joint in np.flatnonzero(failed).tolist():
        rows = scored[:, joint] & np.isfinite(residual[:, joint])
        excess = residual[rows, joint] ** 2 - floor.rms[joint] ** 2
        shares: dict[str, tuple[float, float]] = {}
        for name, (signals, units) in quantities.items():
            low, high = training_range(signals, split.train)
            outside = np.concatenate(outside_of_range(signals, low, high))[rows, joint]
            where = f"its {name} is outside of the {low[joint]:.3g} to {high[joint]:.3g} {units[joint]}"
            shares[where] = float(excess[outside].sum() / excess.sum()), float(outside.mean())
        where, (of_error, of_rows) = max(shares.items(), key=lambda item: item[1][0] - item[1][1])
        if of_error - of_rows > _MIN_BLAME * (1 - of_rows):
            yield (
                f"Joint {joint + 1}: {min(of_error, 1.0):.0%} of the held-out error (mean square above the noise "
                f"floor) is where {where} of the training data, in {of_rows:.0%} of the rows. Effects that occur "
                "only there cannot be identified from the training data: train on a motion that goes there, too."
            )
