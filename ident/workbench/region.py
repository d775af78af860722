"""What is special about a part of a recording: how the joint moves there, compared with everywhere else."""

import numpy as np

from ident.workbench.views import Series
from recordings.recording import Bools, Floats

_LEAST = 5
"""Rows in a part that is judged."""
_STANDS_OUT = 1.5


def special(series: Series, joint: int, start: float, end: float) -> tuple[str, ...]:
    """Sentences about `joint` (from 0) between `start` and `end` [s]."""
    left = series.residual[:, joint]
    known = np.isfinite(left)
    inside = (series.time >= start) & (series.time <= end) & known
    if inside.sum() < _LEAST or not (known & ~inside).any():
        return ("Too little is marked, or all of it; mark a part of the residual.",)
    here, rest = _rms(left[inside]), _rms(left[known & ~inside])
    where = f"{start:.2f} to {end:.2f} s, joint {joint + 1}"
    sentences = [
        f"{where}: residual {here:.3g} RMS, {here / rest:.1f} times that of the rest; "
        f"mean {float(left[inside].mean()):+.3g}."
    ]
    sentences.append(_moving(series, joint, inside, known))
    sentences.append(_phases(series, joint, inside, known))
    return tuple(sentences)


def _moving(series: Series, joint: int, inside: Bools, known: Bools) -> str:
    speed, place = np.abs(series.velocity[:, joint]), series.position[:, joint]
    here, typical = float(np.median(speed[inside])), float(np.median(speed[known]))
    word = "slower than" if here * _STANDS_OUT < typical else "faster than" if here > _STANDS_OUT * typical else "as"
    low, high = (float(np.quantile(place[inside], q)) for q in (0.02, 0.98))
    return (
        f"Speed {here:.2g} in the median, {word} usual ({typical:.2g}); position {low:.2f} to {high:.2f} of "
        f"{float(place[known].min()):.2f} to {float(place[known].max()):.2f} in all."
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
