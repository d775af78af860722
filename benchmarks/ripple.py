"""Count how often one ripple is named as one order whose interval holds it.

Each case is an axis whose torque ripples N times per turn, in three recordings of other speeds; one is held out.
The drive's current loop delays and attenuates the ripple, which therefore depends on direction and speed.
"""

from dataclasses import dataclass, replace

import click
import numpy as np
from scipy.signal import lfilter

from ident.data.prepared_recording import PreparedRecording, prepare
from ident.diagnosis.ripple.ripple import EFFECT, Ripple, find_ripple
from ident.diagnosis.search.search import Search
from ident.diagnosis.search.selection import Selection
from ident.diagnosis.split.train_test_split import split_recordings
from ident.dynamics.effects.library import library
from recordings.recording import Floats, Recording
from tests.ident import building

SECONDS = 9.0
"""Duration of a recording [s]."""
ORDERS = (20, 300)
"""Range of the true order [periods per turn]."""
PASSING = (35.0, 120.0)
"""Range of the frequency with which periods pass at the RMS speed [Hz]; the low-pass is at building.CUTOFF."""


@dataclass(frozen=True)
class NamedRipple:
    """What was said of one recorded ripple."""

    order: int
    """The true one."""
    intervals: tuple[tuple[float, float], ...]
    """95 % interval of each order that is listed."""
    vibrations: tuple[float, ...]
    """Frequencies that are listed [Hz]."""

    @property
    def right(self) -> bool:
        """Whether one order is listed, its interval holds the true one, and nothing else is listed."""
        return (
            len(self.intervals) == 1
            and self.intervals[0][0] <= self.order <= self.intervals[0][1]
            and not self.vibrations
        )


def name_ripple(number: int) -> NamedRipple:
    """Record and analyse case `number`."""
    rng = np.random.default_rng([31, number])
    order = int(rng.integers(*ORDERS, endpoint=True))
    phase, corner = rng.uniform(0, 2 * np.pi), rng.uniform(60.0, 300.0)
    prepared = [_record(rng, order, phase, corner) for _ in range(3)]
    split = split_recordings(prepared[:2], prepared[2:])
    effects = {EFFECT: library()[EFFECT]}
    structure = prepared[0].base_structure
    selection = Search(split, effects, lambda text: None).select(structure, building.start(structure))
    ripple = find_ripple(selection.model, effects)
    return NamedRipple(
        order, (*_below(selection), *_above(ripple)), tuple(each.frequency for each in ripple.vibrations)
    )


def _record(rng: np.random.Generator, order: int, phase: float, corner: float) -> PreparedRecording:
    """corner: frequency above which the current loop attenuates [Hz]."""
    rate = float(rng.choice([500.0, 1000.0]))
    time = np.arange(round(SECONDS * rate)) / rate
    profile = (_fourier if rng.random() < 0.5 else _strokes)(rng, time)
    speed = 2 * np.pi * rng.uniform(*PASSING) / order * profile / np.sqrt(np.mean(profile**2))
    position = np.cumsum(speed) / rate
    acceleration = np.gradient(speed, time)
    size = rng.uniform(0.05, 0.1) * np.where(speed > 0, 1.0, rng.uniform(0.85, 1.15))
    pole = np.exp(-2 * np.pi * corner / rate)
    ripple = lfilter([1 - pole], [1, -pole], size * np.sin(order * position + phase))
    smooth = 0.1 * acceleration / np.std(acceleration) + 0.3 * speed / np.std(speed) + 0.5 * np.tanh(speed / 0.01)
    step = 2 * np.pi / 2 ** int(rng.integers(17, 21))
    reading = step * np.round(position / step)
    measured = smooth + ripple + rng.uniform(0.01, 0.04) * rng.normal(size=len(time))
    return prepare(_recording(time, reading, measured, rate), "parallel", building.CUTOFF)


def _fourier(rng: np.random.Generator, time: Floats) -> Floats:
    """(n,) speed: a sum of sines that do not repeat."""
    waves = [
        np.sin(2 * np.pi * hertz * time + phase) / (1 + hertz)
        for hertz, phase in zip(rng.uniform(0.15, 1.5, 5), rng.uniform(0, 2 * np.pi, 5), strict=True)
    ]
    return np.sum(waves, axis=0)


def _strokes(rng: np.random.Generator, time: Floats) -> Floats:
    """(n,) speed: strokes to and fro, each at a constant speed of its own."""
    period = rng.uniform(1.5, 3.0)
    number = np.floor(time / period).astype(int)
    level = np.repeat(rng.uniform(0.6, 1.0, number[-1] // 2 + 1), 2)[: number[-1] + 1]
    wave = np.sin(2 * np.pi * (time / period - number))
    return level[number] * np.clip(2.5 * wave, -1.0, 1.0)


def _recording(time: Floats, position: Floats, effort: Floats, rate: float) -> Recording:
    empty = building.record(cycles=1)
    position, effort = position[:, None], effort[:, None]
    return replace(
        empty,
        run=empty.run.model_copy(update={"period": SECONDS, "cycles": 1, "rate": rate}),
        time=time,
        position=position,
        command=position,
        voltage=np.full_like(effort, np.nan),
        effort=effort,
        statusword=np.zeros(position.shape, np.uint16),
        error_code=np.zeros(position.shape, np.uint16),
        repeat=np.zeros(len(time), np.int64),
        lateness=np.zeros(len(time)),
    )


def _below(selection: Selection) -> list[tuple[float, float]]:
    """Intervals of the orders below the low-pass."""
    structure, intervals = selection.model.solution.structure, selection.model.shape_intervals
    return [
        (float(low), float(high))
        for entry, (low, high) in zip(structure.parameters, intervals, strict=True)
        if entry.name.split(".")[-1].startswith("N")
    ]


def _above(ripple: Ripple) -> list[tuple[float, float]]:
    return [(line.order - line.half_width[2], line.order + line.half_width[2]) for line in ripple.lines]


@click.command()
@click.option("--cases", default=20, show_default=True, help="Number of cases.")
def main(cases: int) -> None:
    """Print what is said of each case, and in how many of them it is right."""
    right = 0
    for number in range(cases):
        named = name_ripple(number)
        right += named.right
        intervals = ", ".join(f"{(low + high) / 2:.6g} ± {(high - low) / 2:.2g}" for low, high in named.intervals)
        vibrations = ", ".join(f"{hertz:.4g} Hz" for hertz in named.vibrations)
        print(f"{number:3} {named.order:4}: {intervals or 'nothing'}; {vibrations} {'' if named.right else 'WRONG'}")
    print(f"one order whose interval holds the true one: {right} of {cases}")


if __name__ == "__main__":
    main()
