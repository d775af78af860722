"""What can be seen in imported measurements: rate, quantisation, gaps, and what speaks for a wrong unit or column.

What cannot be right is a data problem (`recordings.data_problems`).

Each function below looks at one thing and yields what it sees. A warning says what to do about it.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from recordings.data_problems.signals import MIN_TRAVEL, travel
from recordings.importing import Imported
from recordings.outliers import outliers
from recordings.recording import Floats
from recordings.resolution import resolution

_MIN_RATE = 20.0
"""Below this rate [Hz] friction at reversals and ripple pass between two samples."""
_MAX_JITTER = 0.1
"""Standard deviation of the time steps, relative to their median, that is pointed out."""
_EVEN = 1e-4
"""Time steps with less jitter than this are even."""
_GAP = 1.9
"""A time step this many times the median is a gap."""
_MAX_RANGE = 30.0
"""A range [rad] beyond this is in degrees: five turns of a joint are rare, 30 degrees are not."""
_MAX_SLOPE_ERROR = 0.1
"""A velocity differs from the derivative of the position if its slope is off by more than this share."""
_MIN_CORRELATION = 0.9
"""Below this correlation a velocity is not that of the position at all."""
_MOVING = 0.02
"""A joint moves where it is faster than this share of its highest speed."""
_ONE_WAY = 0.99
"""A motion has one direction if this share of its moving samples has."""
_ONE_SPEED = 0.05
"""A motion has one speed if the speeds of its moving samples vary by less than this share."""
_FALL = 100.0
"""A torque whose noise density falls by this factor from 0.3 ... 0.5 to 0.8 ... 1 of the Nyquist frequency has passed
a low-pass: noise of drives is white there."""
_SPECTRUM_SAMPLES = 256
"""Samples of one spectrum; fewer samples than four of these say nothing about a filter."""


@dataclass(frozen=True)
class Observation:
    """One thing that was seen."""

    name: str
    level: Literal["note", "warning"]
    says: str
    joint: int | None = None
    """Number of the joint; None: of the whole recording."""


def observe(imported: Imported) -> list[Observation]:
    """List what can be seen in `imported`, warnings last."""
    seen = [observation for look in _LOOKS for observation in look(imported)]
    return sorted(seen, key=lambda observation: observation.level == "warning")


def _rate(imported: Imported) -> Iterator[Observation]:
    step = float(np.median(imported.steps))
    jitter = float(np.std(imported.steps[imported.steps < _GAP * step]) / step)
    steps = f"steps jitter by {100 * jitter:.2g} %" if jitter > _EVEN else "even steps"
    yield Observation("rate", "note", f"rate {1 / step:.4g} Hz, {steps}")
    if 1 / step < _MIN_RATE:
        yield Observation(
            "low-rate",
            "warning",
            f"{1 / step:.3g} Hz is below {_MIN_RATE:g} Hz: reversals and ripple pass between samples; record faster",
        )
    if jitter > _MAX_JITTER:
        yield Observation(
            "jitter",
            "warning",
            f"time steps vary by {100 * jitter:.0f} %: use the stamps of the drive, not those of arrival",
        )


def _gaps(imported: Imported) -> Iterator[Observation]:
    step = float(np.median(imported.steps))
    long = imported.steps > _GAP * step
    if long.any():
        text = f"{_count(int(long.sum()), 'gap')} in time, the longest {imported.steps.max():.4g} s, not filled"
        yield Observation("time-gaps", "note", text)
    for name in ("position", "voltage", "effort"):
        for joint, column in _columns(imported, name):
            if np.isnan(column).any():
                count = _count(int(np.isnan(column).sum()), "gap")
                yield Observation("gaps", "note", f"{name} {joint}: {count}", joint)


def _empty(imported: Imported) -> Iterator[Observation]:
    for joint, column in _columns(imported, "position"):
        known = column[np.isfinite(column)]
        if travel(column) < MIN_TRAVEL:
            yield Observation(
                "joint-at-rest",
                "warning",
                f"joint {joint} does not move ({'no position' if not len(known) else f'{known[0]:g} throughout'}): "
                "check its column, or leave the joint out",
                joint,
            )


def _angle(imported: Imported) -> Iterator[Observation]:
    if imported.rig.mechanism == "urdf":  # whose limits say more: `ident.data_problems.angle_scale`
        return
    for joint, column in _columns(imported, "position"):
        column = column[~outliers(column)]
        if imported.rig.joint_types[joint - 1] != "revolute" or not np.isfinite(column).any():
            continue
        extent, largest = float(np.nanmax(column) - np.nanmin(column)), float(np.nanmax(np.abs(column)))
        if extent > _MAX_RANGE:
            text = (
                f"position {joint} spans {extent:.4g} rad: degrees are likely; import again with --map "
                f'"position_{joint}=COLUMN:deg"'
            )
            yield Observation("degrees", "warning", text, joint)
        elif largest > 2 * np.pi and imported.rig.mechanism != "delta":
            text = f"position {joint} reaches {largest:.3g} rad, beyond one turn: check the unit and the gear"
            yield Observation("beyond-a-turn", "warning", text, joint)


def _resolution(imported: Imported) -> Iterator[Observation]:
    units = {"position": imported.rig.position_units[0], "voltage": "V", "effort": imported.rig.effort_units[0]}
    for name, unit in units.items():
        steps = [resolution(column) for _, column in _columns(imported, name)]
        if any(steps):
            listed = ", ".join(f"{step:.3g}" if step else "none" for step in steps)
            yield Observation("resolution", "note", f"resolution of {name}: {listed} {unit}")


def _velocity(imported: Imported) -> Iterator[Observation]:
    for joint, column in _columns(imported, "velocity"):
        derivative = _derivative(imported, joint)
        known = np.isfinite(derivative) & np.isfinite(column)
        derivative, column = derivative[known], column[known]
        # Squares of tiny values vanish.
        if len(column) < 3 or not all(np.ptp(values) and np.var(values) for values in (derivative, column)):
            continue
        correlation = float(np.corrcoef(column, derivative)[0, 1])
        slope = float(column @ derivative / (derivative @ derivative))
        if abs(correlation) < _MIN_CORRELATION:
            text = f"velocity {joint} is not the derivative of position {joint} (correlation {correlation:.2f})"
            yield Observation("velocity", "warning", f"{text}: check both columns", joint)
        elif abs(slope - 1) > _MAX_SLOPE_ERROR:
            text = f"velocity {joint} is {slope:.3g} times the derivative of position {joint}: check both units"
            yield Observation("velocity", "warning", text, joint)


def _motion(imported: Imported) -> Iterator[Observation]:
    for joint, column in _columns(imported, "position"):
        velocity = _derivative(imported, joint)
        velocity = velocity[np.isfinite(velocity)]
        fastest = float(np.quantile(np.abs(velocity), 0.99)) if len(velocity) else 0.0
        moving = velocity[np.abs(velocity) > _MOVING * fastest]
        if travel(column) < MIN_TRAVEL or not len(moving):
            continue
        if max(np.mean(moving > 0), np.mean(moving < 0)) > _ONE_WAY:
            text = f"joint {joint} moves in one direction only: Coulomb friction and offset cannot be told apart"
            yield Observation("one-direction", "warning", f"{text}; record both", joint)
        if np.std(np.abs(moving)) < _ONE_SPEED * np.mean(np.abs(moving)):
            text = f"joint {joint} moves at one speed only: friction over speed cannot be seen"
            yield Observation("one-speed", "warning", f"{text}; record several speeds", joint)


def _filtered(imported: Imported) -> Iterator[Observation]:
    for name in ("voltage", "effort"):
        corners = [_corner(imported, column) for _, column in _columns(imported, name)]
        if corners and all(corners):
            listed = ", ".join(f"{corner:.3g}" for corner in corners)
            text = f"{name} holds hardly any noise above {listed} Hz: it was low-passed before; ripple above is lost"
            yield Observation("filtered", "warning", text)


def _corner(imported: Imported, values: Floats) -> float | None:
    """Frequency above which the noise of `values` (n,) falls [Hz]; None where it does not."""
    from scipy.signal import welch

    known = np.isfinite(values)
    if known.sum() < 4 * _SPECTRUM_SAMPLES or not np.ptp(values[known]):
        return None
    frequency, density = welch(values[known], 1 / np.median(imported.steps), nperseg=_SPECTRUM_SAMPLES)
    share = frequency / frequency[-1]
    middle = np.median(density[(share > 0.3) & (share < 0.5)])
    top = np.median(density[share > 0.8])
    if not middle > _FALL * top:  # both may be 0
        return None
    return float(frequency[density > _FALL * top][-1])


def _columns(imported: Imported, name: str) -> Iterator[tuple[int, Floats]]:
    """Number of each joint and its column (n,) of a quantity."""
    table = getattr(imported.samples, name)
    return iter(()) if table is None else enumerate(table.T, start=1)


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _derivative(imported: Imported, joint: int) -> Floats:
    """Derivative (n,) of the position of a joint."""
    return np.gradient(imported.samples.position[:, joint - 1], imported.samples.stamp / 1e9)


_LOOKS: tuple[Callable[[Imported], Iterator[Observation]], ...] = (
    _rate,
    _gaps,
    _resolution,
    _empty,
    _angle,
    _velocity,
    _motion,
    _filtered,
)
