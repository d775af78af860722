"""Warn where test recordings leave the range of the training data and the model fails there.

An effect that occurs only outside of that range, such as backlash without load reversal or saturation that was never
reached, cannot be identified from the training data. The error in those rows is no evidence against the model.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import BLOCK_SECONDS
from ident.diagnosis.split.noise_floor import NoiseFloor
from ident.diagnosis.split.split_data import SplitData, rms
from ident.diagnosis.split.training_range import outside_of_range, training_range
from recordings.recording import Bools

_MIN_FAILURE = 1.25
"""A joint fails if its error exceeds the noise floor by this factor: the floor is not known more accurately."""
_MIN_BLAMED_SHARE = 0.7
"""Share of the excess error that must lie outside of the range to be explained by it."""
_MIN_DENSITY_RATIO = 3.0
"""Per row, the excess error outside of the range must be this many times that inside."""
_MIN_INSIDE_SHARE = 0.2
"""Share of the rows that must lie inside the range: a motion entirely outside of it explains nothing."""
_MAX_BLOCK_SHARE = 0.5
"""Share of the excess error that a single block of time may hold: more is an isolated event."""
_FILTER_SPREAD = 1.5
"""A filter spreads an instantaneous event over this many periods of the bandwidth."""
_TINY = 1e-12


@dataclass(frozen=True, eq=False)
class TrainingRange:
    """The range of a quantity of one joint in the training rows."""

    joint: int
    """From 0."""
    text: str
    """Description with the unit."""
    outside: tuple[Bools, ...]
    """(m,) rows of each recording outside of the range."""


def extrapolation_warnings(split: SplitData, model: FittedModel, floor: NoiseFloor) -> Iterator[str]:
    """Yield one sentence for each range that the test recordings leave, if the `model` fails there."""
    if not split.other_motion:
        return
    failed_joints = np.flatnonzero(rms(model.residuals, split.test) > _MIN_FAILURE * floor.rms)
    ranges = list(_ranges(split)) if len(failed_joints) else []
    blamed: dict[str, list[tuple[int, float]]] = {}
    for joint in map(int, failed_joints):
        shares = [
            (_excess_share(split, model, floor, training_range.outside, joint), training_range)
            for training_range in ranges
        ]
        large = [(share, training_range) for share, training_range in shares if share > _MIN_BLAMED_SHARE]
        if large:  # a range of the joint itself is the likelier reason
            share, training_range = max(large, key=lambda item: (item[1].joint == joint, item[0]))
            blamed.setdefault(training_range.text, []).append((joint + 1, min(share, 1.0)))
    for text, joints in blamed.items():
        numbers, smallest = ", ".join(str(joint) for joint, _ in joints), min(share for _, share in joints)
        yield (
            f"Joint{'s' if len(joints) > 1 else ''} {numbers}: {smallest:.0%} of the held-out error above the "
            f"noise floor is where {text}. Effects that occur only there cannot be identified from the training "
            "data: train on a motion that goes there, too."
        )


def _ranges(split: SplitData) -> Iterator[TrainingRange]:
    rig = split.recordings[0].recording.rig
    for name, series in (
        ("torque", [data.torque for data in split.recordings]),
        ("speed", [data.motion.velocity for data in split.recordings]),
        ("position", [data.motion.position for data in split.recordings]),
    ):
        low, high = training_range(series, split.train)
        outside = outside_of_range(series, low, high)
        for joint, (effort, angle) in enumerate(zip(rig.effort_units, rig.position_units, strict=True)):
            unit = {"torque": effort, "speed": f"{angle}/s"}.get(name, angle)
            limits = f"{low[joint]:.3g} to {high[joint]:.3g} {unit}"
            if np.isfinite(low[joint]):  # the joint moves at some time
                yield TrainingRange(
                    joint,
                    f"the {name} of joint {joint + 1} is outside of the {limits} of the training data",
                    tuple(
                        _dilated(rows[:, joint], data.rate * _FILTER_SPREAD / data.bandwidth)
                        for rows, data in zip(outside, split.recordings, strict=True)
                    ),
                )


def _dilated(rows: Bools, distance: float) -> Bools:
    """(m,) `rows`, extended by `distance` rows to both sides."""
    from scipy.ndimage import maximum_filter1d

    dilated: Bools = maximum_filter1d(rows, 2 * int(distance) + 1)
    return dilated


def _excess_share(
    split: SplitData, model: FittedModel, floor: NoiseFloor, outside: Sequence[Bools], joint: int
) -> float:
    """Share of the excess mean square of a `joint` on the test rows that lies in the rows `outside`."""
    squares, outside_flags, largest_block, scale = [], [], 0.0, max(float(floor.rms[joint]), _TINY)
    for data, residual, test, flags in zip(split.recordings, model.residuals, split.test, outside, strict=True):
        scored = test[:, joint] & np.isfinite(residual[:, joint])
        squares.append((residual[scored, joint] / scale) ** 2 - 1)
        outside_flags.append(flags[scored])
        if scored.any():
            largest_block = max(
                largest_block,
                float(np.bincount((data.time[scored] // BLOCK_SECONDS).astype(int), squares[-1].clip(0)).max()),
            )
    excess, out = np.concatenate(squares), np.concatenate(outside_flags)
    if not out.any() or out.mean() > 1 - _MIN_INSIDE_SHARE or largest_block > _MAX_BLOCK_SHARE * excess.sum():
        return 0.0
    uniform = excess[out].mean() < _MIN_DENSITY_RATIO * excess[~out].mean()
    return 0.0 if uniform else float(excess[out].sum() / excess.sum())
