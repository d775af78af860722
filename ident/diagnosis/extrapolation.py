"""Where held-out recordings go beyond what fits have seen, and whether it is there that the model fails.

An effect that shows only there - play where the load never changed its side, saturation that was never reached -
cannot be known from the training; the error of the held-out rows says nothing against the model then.
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

_FAILS = 1.25
"""A joint that leaves no more than so many times its floor does not fail: the floor is not known that well."""
_MARGIN = 0.02
"""Of the range seen, by which it may be left."""
_MOST = 0.7
"""Share of what is above the floor that has to be beyond the range to be blamed on that."""
_DENSER = 3.0
"""So many times as much has to be above the floor there, row by row, as within the range."""
_WITHIN = 0.2
"""Share of the rows that has to be within it: a motion that is elsewhere altogether says nothing of why."""
_ONE = 0.5
"""Share of it that a single stretch of time may hold: more is an event, and may be anything."""
_SPREAD = 1.5
"""A filter spreads what happens at an instant over so many periods of the bandwidth."""
_TINY = 1e-12


@dataclass(frozen=True, eq=False)
class TrainingRange:
    """Of a quantity of one joint, as the fits have seen it."""

    joint: int
    """From 0."""
    text: str
    """In words, with its unit."""
    outside: tuple[Bools, ...]
    """(m,) of each recording."""


def extrapolation_warnings(material: SplitData, state: FittedModel, floor: NoiseFloor) -> Iterator[str]:
    """A sentence for each range that held-out recordings leave, and where the model `state` fails for it."""
    if not material.other_motion:
        return
    failing = np.flatnonzero(rms(state.residuals, material.test) > _FAILS * floor.rms)
    ranges = list(_ranges(material)) if len(failing) else []
    blamed: dict[str, list[tuple[int, float]]] = {}
    for joint in map(int, failing):
        shares = [(_share(material, state, floor, one.outside, joint), one) for one in ranges]
        found = [(share, one) for share, one in shares if share > _MOST]
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
        _spread((one < low - margin) | (one > high + margin), data.rate * _SPREAD / data.bandwidth)
        for one, data in zip(values, material.datasets, strict=True)
    )
    text = f"the {name} is outside of the {low:.3g} to {high:.3g} {unit} that the fit has seen"
    return TrainingRange(joint, text, outside)


def _spread(rows: Bools, by: float) -> Bools:
    """(m,) also those rows that are no more than so many away."""
    around: Bools = maximum_filter1d(rows, 2 * int(by) + 1)
    return around


def _share(material: SplitData, state: FittedModel, floor: NoiseFloor, outside: Sequence[Bools], joint: int) -> float:
    """Of the mean square above the floor that a `joint` leaves held out, that of the rows `outside`."""
    squares, far, most, size = [], [], 0.0, max(float(floor.rms[joint]), _TINY)
    for data, residual, held, away in zip(material.datasets, state.residuals, material.test, outside, strict=True):
        known = held[:, joint] & np.isfinite(residual[:, joint])
        squares.append((residual[known, joint] / size) ** 2 - 1)
        far.append(away[known])
        if known.any():
            most = max(most, float(np.bincount((data.time[known] // BLOCK_SECONDS).astype(int), squares[-1].clip(0)).max()))
    above, there = np.concatenate(squares), np.concatenate(far)
    if not there.any() or there.mean() > 1 - _WITHIN or most > _ONE * above.sum():
        return 0.0
    alike = above[there].mean() < _DENSER * above[~there].mean()
    return 0.0 if alike else float(above[there].sum() / above.sum())
