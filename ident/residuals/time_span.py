"""A span of time that somebody has selected: what the residual is there, and which effects would explain it."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recordings.recording import Bools, Floats, Ints

Float32s = NDArray[np.float32]
"""Single precision keeps the memory for an hour at 500 Hz small."""
_MIN_ROWS = 5
"""Smallest number of rows in a span that is described."""
_NOTABLE_RATIO = 1.5
MIN_SHARE = 0.1
"""Smallest share of the span's mean square that counts as explained."""


@dataclass(frozen=True, eq=False)
class TorqueSeries:
    """Measured and computed torque of one recording at the rate of the analysis: m instants, dof joints."""

    name: str
    held_out: bool
    time: Floats
    measured: Floats
    computed: Floats
    velocity: Floats
    position: Floats
    phase: NDArray[np.str_]
    """(m, dof) motion phase of each joint."""
    cycle: Ints
    """(m,) cycle of the motion, from 1; 0 outside of the cycles."""
    scored: Bools
    """(m, dof) rows that enter the error."""
    previous: Floats | None = None
    """(m, dof) torque of the model before the last change; None for the first model."""

    @property
    def residual(self) -> Floats:
        """Return measured minus computed torque (m, dof); NaN where a row is not scored."""
        return np.where(self.scored, self.measured - self.computed, np.nan)


def describe_span(
    series: TorqueSeries, joint: int, start: float, end: float, unit: str = "N m", angle: str = "rad"
) -> tuple[str, ...]:
    """Describe `joint` (from 0) between `start` and `end` [s]; `unit` of effort, `angle` of position."""
    residual = series.residual[:, joint]
    valid = np.isfinite(residual)
    inside = (series.time >= start) & (series.time <= end) & valid
    if inside.sum() < _MIN_ROWS or not (valid & ~inside).any():
        return ("The selection is too short, or covers everything; select a part of the residual.",)
    rms_inside, rms_outside = _rms(residual[inside]), _rms(residual[valid & ~inside])
    return (
        f"{start:.2f} to {end:.2f} s, joint {joint + 1}: residual {rms_inside:.3g} {unit} RMS, "
        f"{rms_inside / rms_outside:.1f} times the residual elsewhere; "
        f"mean {float(residual[inside].mean()):+.3g} {unit}.",
        _motion_sentence(series, joint, inside, valid, angle),
        _phase_sentence(series, joint, inside, valid),
    )


def explain_gaps(series: TorqueSeries, joint: int) -> str:
    """Say which rows of `joint` (from 0) have no residual, and why; empty if all have one."""
    missing = ~np.isfinite(series.residual[:, joint])
    outside = missing & (series.cycle == 0) & bool((series.cycle > 0).any())
    lost = missing & ~outside & ~np.isfinite(series.measured[:, joint])
    reasons = {
        "outside of the repeated motion": outside,
        "lost, or too close to the ends to be filtered": lost,
        "at standstill, where friction has no direction, near saturation, or kept apart for the test": missing
        & ~lost
        & ~outside,
    }
    parts = [f"{rows.mean():.0%} {reason}" for reason, rows in reasons.items() if rows.any()]
    return f"Gaps in the residual are rows that are not scored: {'; '.join(parts)}." if parts else ""


def rank_effects(
    series: TorqueSeries, contributions: Mapping[str, Float32s], joint: int, start: float, end: float
) -> dict[str, float]:
    """Return the share of the residual of `joint` (from 0) between `start` and `end` [s] that each effect explains.

    contributions: (m, dof) by effect, with coefficients fitted to all rows. An effect that would explain the span
    only at the expense of the rest therefore ranks low. The result is in descending order of the share of the
    residual's mean square, which is negative if the effect increases it; empty for a span that is too short.
    """
    residual = series.residual[:, joint]
    inside = (series.time >= start) & (series.time <= end) & np.isfinite(residual)
    if inside.sum() < _MIN_ROWS:
        return {}
    total = _rms(residual[inside])
    shares = {}
    for effect, torque in contributions.items():
        remaining = _rms(residual[inside] - np.nan_to_num(torque[inside, joint].astype(float)))
        shares[effect] = 1 - (remaining / total) ** 2 if total else 0.0
    return dict(sorted(shares.items(), key=lambda item: -item[1]))


def summary(shares: Mapping[str, float]) -> str:
    """Return the heading of the ranking."""
    if not shares:
        return "The selection is too short to say what explains it."
    best, share = next(iter(shares.items()))
    if share >= MIN_SHARE:
        return "Effects that would explain this selection, with coefficients fitted to the whole recording:"
    return (
        f"No effect of the library explains this selection: {best} explains most, {100 * max(share, 0.0):.0f} % of "
        "its mean square."
    )


def _motion_sentence(series: TorqueSeries, joint: int, inside: Bools, valid: Bools, angle: str) -> str:
    speed, position = np.abs(series.velocity[:, joint]), series.position[:, joint]
    here, typical = float(np.median(speed[inside])), float(np.median(speed[valid]))
    comparison = (
        "slower than"
        if here * _NOTABLE_RATIO < typical
        else "faster than"
        if here > _NOTABLE_RATIO * typical
        else "as"
    )
    low, high = (float(np.quantile(position[inside], q)) for q in (0.02, 0.98))
    return (
        f"Speed {here:.2g} {angle}/s median, {comparison} usual ({typical:.2g} {angle}/s); position {low:.2f} to "
        f"{high:.2f} {angle} of {float(position[valid].min()):.2f} to {float(position[valid].max()):.2f} {angle}."
    )


def _phase_sentence(series: TorqueSeries, joint: int, inside: Bools, valid: Bools) -> str:
    phase = series.phase[:, joint]
    names = [str(name) for name in np.unique(phase[inside])]
    shares = {name: float((phase[inside] == name).mean()) for name in names}
    usual = {name: float((phase[valid] == name).mean()) for name in names}
    most = sorted(names, key=lambda name: -shares[name])
    text = ", ".join(f"{name} {100 * shares[name]:.0f} % (usually {100 * usual[name]:.0f} %)" for name in most)
    cycles = [int(cycle) for cycle in np.unique(series.cycle[inside]) if cycle > 0]
    return f"Motion phases: {text}." + (f" Cycle {', '.join(map(str, cycles))}." if cycles else "")


def _rms(x: Floats) -> float:
    return float(np.sqrt(np.mean(x**2)))
