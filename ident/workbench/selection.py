"""Description of a selected time span: its residual, its motion, and the effects that would explain it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ident.workbench.views import TorqueSeries, Float32s
from recordings.recording import Bools, Floats

_MIN_ROWS = 5
"""Smallest number of rows in a span that is described."""
_NOTABLE_RATIO = 1.5
MIN_SHARE = 0.1
"""Smallest share of the span's mean square that counts as explained."""


def describe_span(
    series: TorqueSeries, joint: int, start: float, end: float, unit: str = "N m", angle: str = "rad"
) -> tuple[str, ...]:
    """Describe `joint` (from 0) between `start` and `end` [s]; `unit` of effort, `angle` of position."""
    left = series.residual[:, joint]
    known = np.isfinite(left)
    inside = (series.time >= start) & (series.time <= end) & known
    if inside.sum() < _MIN_ROWS or not (known & ~inside).any():
        return ("The selection is too short, or covers everything; select a part of the residual.",)
    here, rest = _rms(left[inside]), _rms(left[known & ~inside])
    where = f"{start:.2f} to {end:.2f} s, joint {joint + 1}"
    sentences = [
        f"{where}: residual {here:.3g} {unit} RMS, {here / rest:.1f} times the residual elsewhere; "
        f"mean {float(left[inside].mean()):+.3g} {unit}."
    ]
    sentences.append(_motion_sentence(series, joint, inside, known, angle))
    sentences.append(_phase_sentence(series, joint, inside, known))
    return tuple(sentences)


@dataclass(frozen=True)
class ExplainedShare:
    """Share of a span's residual that one effect would explain."""

    effect: str
    share: float
    """Share of the residual's mean square in the span; negative if the effect increases it."""


def rank_effects(
    series: TorqueSeries, contributions: Mapping[str, Float32s], joint: int, start: float, end: float
) -> tuple[ExplainedShare, ...]:
    """Rank effects by the share of the residual of `joint` (from 0) between `start` and `end` [s] that they explain.

    contributions: (m, dof) by effect, with coefficients fitted to all rows. An effect that would explain the span only at
    the expense of the rest therefore ranks low.
    """
    left = series.residual[:, joint]
    inside = (series.time >= start) & (series.time <= end) & np.isfinite(left)
    if inside.sum() < _MIN_ROWS:
        return ()
    before = _rms(left[inside]) ** 2
    found = []
    for effect, torque in contributions.items():
        rows = torque[inside, joint].astype(float)
        share = 1 - float(np.mean((left[inside] - np.nan_to_num(rows)) ** 2)) / before if before else 0.0
        found.append(ExplainedShare(effect, share))
    return tuple(sorted(found, key=lambda one: -one.share))


def summary(ranking: Sequence[ExplainedShare]) -> str:
    """Return the heading of the ranking."""
    if not ranking:
        return "The selection is too short to say what explains it."
    if ranking[0].share >= MIN_SHARE:
        return "Effects that would explain this selection, with coefficients fitted to the whole recording:"
    best = f"{ranking[0].effect} explains most, {100 * max(ranking[0].share, 0.0):.0f} %"
    return f"No effect of the library explains this selection: {best} of its mean square."


def _motion_sentence(series: TorqueSeries, joint: int, inside: Bools, valid: Bools, angle: str) -> str:
    speed, place = np.abs(series.velocity[:, joint]), series.position[:, joint]
    here, typical = float(np.median(speed[inside])), float(np.median(speed[valid]))
    word = "slower than" if here * _NOTABLE_RATIO < typical else "faster than" if here > _NOTABLE_RATIO * typical else "as"
    low, high = (float(np.quantile(place[inside], q)) for q in (0.02, 0.98))
    return (
        f"Speed {here:.2g} {angle}/s median, {word} usual ({typical:.2g} {angle}/s); position {low:.2f} to "
        f"{high:.2f} {angle} of {float(place[valid].min()):.2f} to {float(place[valid].max()):.2f} {angle} in all."
    )


def _phase_sentence(series: TorqueSeries, joint: int, inside: Bools, valid: Bools) -> str:
    phase = series.phase[:, joint]
    names = [str(one) for one in np.unique(phase[inside])]
    shares = {one: float((phase[inside] == one).mean()) for one in names}
    usual = {one: float((phase[valid] == one).mean()) for one in names}
    most = sorted(names, key=lambda one: -shares[one])
    told = ", ".join(f"{one} {100 * shares[one]:.0f} % (usually {100 * usual[one]:.0f} %)" for one in most)
    cycles = [int(one) for one in np.unique(series.cycle[inside]) if one > 0]
    repeats = f" Cycle {', '.join(map(str, cycles))}." if cycles else ""
    return f"Motion phases: {told}.{repeats}"


def _rms(x: Floats) -> float:
    return float(np.sqrt(np.mean(x**2)))
