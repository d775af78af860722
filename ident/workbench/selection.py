"""What is special about a part of a recording: how the joint moves there, compared with everywhere else."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ident.workbench.views import Series, Small
from recordings.recording import Bools, Floats

_LEAST = 5
"""Rows in a part that is judged."""
_STANDS_OUT = 1.5
WORTH = 0.1
"""Share of a part's mean square from which on an effect is said to explain something of it."""


def special(
    series: Series, joint: int, start: float, end: float, unit: str = "N m", angle: str = "rad"
) -> tuple[str, ...]:
    """Sentences about `joint` (from 0) between `start` and `end` [s]; units of effort and position."""
    left = series.residual[:, joint]
    known = np.isfinite(left)
    inside = (series.time >= start) & (series.time <= end) & known
    if inside.sum() < _LEAST or not (known & ~inside).any():
        return ("Too little is marked, or all of it; mark a part of the residual.",)
    here, rest = _rms(left[inside]), _rms(left[known & ~inside])
    where = f"{start:.2f} to {end:.2f} s, joint {joint + 1}"
    sentences = [
        f"{where}: residual {here:.3g} {unit} RMS, {here / rest:.1f} times that of the rest; "
        f"mean {float(left[inside].mean()):+.3g} {unit}."
    ]
    sentences.append(_moving(series, joint, inside, known, angle))
    sentences.append(_phases(series, joint, inside, known))
    return tuple(sentences)


@dataclass(frozen=True)
class Explained:
    """What one effect would take away of a part."""

    effect: str
    share: float
    """Of the residual's mean square there, 0 to 1."""


def explaining(
    series: Series, removed: Mapping[str, Small], joint: int, start: float, end: float
) -> tuple[Explained, ...]:
    """The effects that would take away most of what `joint` (from 0) leaves between `start` and `end` [s].

    removed: (m, dof) by effect, with coefficients that were found from all rows, not from this part: an effect that
    explains the part only by spoiling the rest does not stand here.
    """
    left = series.residual[:, joint]
    inside = (series.time >= start) & (series.time <= end) & np.isfinite(left)
    if inside.sum() < _LEAST:
        return ()
    before = _rms(left[inside]) ** 2
    found = []
    for effect, torque in removed.items():
        rows = torque[inside, joint].astype(float)
        share = 1 - float(np.mean((left[inside] - np.nan_to_num(rows)) ** 2)) / before if before else 0.0
        found.append(Explained(effect, share))
    return tuple(sorted(found, key=lambda one: -one.share))


def verdict(found: Sequence[Explained]) -> str:
    """What is to be said above the list of those that explain something."""
    if not found:
        return "Too little is marked to say what explains it."
    if found[0].share >= WORTH:
        return "What would explain this part, with coefficients fitted to the whole recording:"
    best = f"{found[0].effect} takes away most, {100 * max(found[0].share, 0.0):.0f} %"
    return f"No effect of the library explains this part: {best} of its mean square."


def _moving(series: Series, joint: int, inside: Bools, known: Bools, angle: str) -> str:
    speed, place = np.abs(series.velocity[:, joint]), series.position[:, joint]
    here, typical = float(np.median(speed[inside])), float(np.median(speed[known]))
    word = "slower than" if here * _STANDS_OUT < typical else "faster than" if here > _STANDS_OUT * typical else "as"
    low, high = (float(np.quantile(place[inside], q)) for q in (0.02, 0.98))
    return (
        f"Speed {here:.2g} {angle}/s in the median, {word} usual ({typical:.2g} {angle}/s); position {low:.2f} to "
        f"{high:.2f} {angle} of {float(place[known].min()):.2f} to {float(place[known].max()):.2f} {angle} in all."
    )


def _phases(series: Series, joint: int, inside: Bools, known: Bools) -> str:
    phase = series.phase[:, joint]
    names = [str(one) for one in np.unique(phase[inside])]
    shares = {one: float((phase[inside] == one).mean()) for one in names}
    usual = {one: float((phase[known] == one).mean()) for one in names}
    most = sorted(names, key=lambda one: -shares[one])
    told = ", ".join(f"{one} {100 * shares[one]:.0f} % (usually {100 * usual[one]:.0f} %)" for one in most)
    cycles = [int(one) for one in np.unique(series.cycle[inside]) if one > 0]
    repeats = f" Cycle {', '.join(map(str, cycles))}." if cycles else ""
    return f"The joint does: {told}.{repeats}"


def _rms(x: Floats) -> float:
    return float(np.sqrt(np.mean(x**2)))
