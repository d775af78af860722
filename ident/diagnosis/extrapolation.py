"""Warn where test recordings leave the range of the training data and the model fails there.

An effect that occurs only outside of that range, such as backlash without load reversal or saturation that was never
reached, cannot be identified from the training data. The error in those rows is no evidence against the model.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d

from ident.diagnosis.improvement import BLOCK_SECONDS
from ident.diagnosis.noise_floor import NoiseFloor
from ident.diagnosis.split_data import SplitData, rms
from ident.diagnosis.steps import FittedModel
from recordings.recording import Bools, Floats

_MIN_FAILURE = 1.25
"""A joint fails if its error exceeds the noise floor by this factor: the floor is not known more accurately."""
_MARGIN = 0.02
"""Share of the training range by which it may be exceeded."""
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


def extrapolation_warnings(material: SplitData, state: FittedModel, floor: NoiseFloor) -> Iterator[str]:
    """Yield one sentence for each range that the test recordings leave, if the `model` fails there."""
    if not material.other_motion:
        return
    failing = np.flatnonzero(rms(state.residuals, material.test) > _MIN_FAILURE * floor.rms)
    ranges = list(_ranges(material)) if len(failing) else []
    blamed: dict[str, list[tuple[int, float]]] = {}
    for joint in map(int, failing):
        shares = [(_excess_share(material, state, floor, one.outside, joint), one) for one in ranges]
        found = [(share, one) for share, one in shares if share > _MIN_BLAMED_SHARE]
        if found:  # what the joint itself does is the likelier reason
            share, one = max(found, key=lambda each: (each[1].joint == joint, each[0]))
            blamed.setdefault(one.text, []).append((joint + 1, min(share, 1.0)))
    for text, joints in blamed.items():
        who, least = ", ".join(str(joint) for joint, _ in joints), min(share for _, share in joints)
        yield (
            f"Joint{'s' if len(joints) > 1 else ''} {who}: {least:.0%} of the held-out error above the noise floor "
            f"is where {text}. What shows only there cannot be known from the training: train on a motion that goes "
            "there, too."
        )


def _ranges(material: SplitData) -> Iterator[TrainingRange]:
    rig = material.datasets[0].recording.rig
    for name, of in (
        ("torque", [data.torque for data in material.datasets]),
        ("speed", [data.motion.velocity for data in material.datasets]),
        ("position", [data.motion.position for data in material.datasets]),
    ):
        for joint, (effort, angle) in enumerate(zip(rig.effort_units, rig.position_units, strict=True)):
            unit = {"torque": effort, "speed": f"{angle}/s"}.get(name, angle)
            values = [one[:, joint] for one in of]
            seen = np.concatenate([values[i][material.train[i][:, joint]] for i in material.train_indices])
            if len(seen):  # it does not stand still all the time
                yield _range(material, values, seen, joint, f"{name} of joint {joint + 1}", unit)


def _range(material: SplitData, values: Sequence[Floats], seen: Floats, joint: int, name: str, unit: str) -> TrainingRange:
    low, high = float(np.nanmin(seen)), float(np.nanmax(seen))
    margin = _MARGIN * (high - low)
    outside = tuple(
        _dilated((one < low - margin) | (one > high + margin), data.rate * _FILTER_SPREAD / data.bandwidth)
        for one, data in zip(values, material.datasets, strict=True)
    )
    text = f"the {name} is outside of the {low:.3g} to {high:.3g} {unit} that the fit has seen"
    return TrainingRange(joint, text, outside)


def _dilated(rows: Bools, by: float) -> Bools:
    """(m,) `rows`, extended by `distance` rows to both sides."""
    around: Bools = maximum_filter1d(rows, 2 * int(by) + 1)
    return around


def _excess_share(material: SplitData, state: FittedModel, floor: NoiseFloor, outside: Sequence[Bools], joint: int) -> float:
    """Share of the excess mean square of a `joint` on the test rows that lies in the rows `outside`."""
    squares, far, most, size = [], [], 0.0, max(float(floor.rms[joint]), _TINY)
    for data, residual, held, away in zip(material.datasets, state.residuals, material.test, outside, strict=True):
        known = held[:, joint] & np.isfinite(residual[:, joint])
        squares.append((residual[known, joint] / size) ** 2 - 1)
        far.append(away[known])
        if known.any():
            most = max(most, float(np.bincount((data.time[known] // BLOCK_SECONDS).astype(int), squares[-1].clip(0)).max()))
    above, there = np.concatenate(squares), np.concatenate(far)
    if not there.any() or there.mean() > 1 - _MIN_INSIDE_SHARE or most > _MAX_BLOCK_SHARE * above.sum():
        return 0.0
    alike = above[there].mean() < _MIN_DENSITY_RATIO * above[~there].mean()
    return 0.0 if alike else float(above[there].sum() / above.sum())
