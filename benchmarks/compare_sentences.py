"""Count how often the first sentence of `ident compare` names the variable of the one cause that a model lacks.

`python -m benchmarks.compare_sentences`. On axes, the torque is planted into the measured one; on the delta robot, it
is that of another plant (tests/foreign). The model is fitted without the cause, or, where a parameter is wrong, to a
machine that has it right.
"""

import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import click
import numpy as np

import ident
from ident.dynamics.motion import Motion
from ident.identification.prediction import Prediction
from ident.residuals.analysis import analyse
from recordings.recording import Floats
from tests.foreign.pairs import TRAIN, VALIDATE, Setting, make
from tests.ident import building

Torque = Callable[[Motion, Floats], Floats]
"""Torque (n,) of the first joint from a motion and the time (n,) [s]."""

NOISE = 0.05
"""Of the measured torque on axes [N m]; their torque is about 5 N m RMS."""
JOINTS = 2


@dataclass(frozen=True)
class OnAxes:
    """A cause on the first of two axes, whose torque is planted."""

    expected: str
    """What the first sentence must contain."""
    torque: Torque
    size: float
    """RMS of the planted torque [N m]."""
    shape: int
    """Number of the motion."""
    parameter: bool = False
    """Whether the torque is that of a wrong parameter, which a fit would take up."""

    def sentence(self) -> str:
        """First sentence of the comparison."""
        time = np.arange(len(building.motion_of(JOINTS).position)) / building.RATE
        planted = np.zeros((len(time), JOINTS))
        planted[:, 0] = self.torque(building.motion_of(JOINTS, shape=self.shape), time)
        planted *= self.size / np.sqrt(np.mean(planted[:, 0] ** 2))
        record = partial(building.record, JOINTS, noise=NOISE, seed=self.shape, shape=self.shape)
        recording = record(extra=lambda motion: planted)
        model = building.fitted(building.split([record() if self.parameter else recording]))
        prepared = building.prepared(recording)
        return analyse(None, [Prediction(prepared, model.computed[0], model.split.scored[0])]).sentences[0]


@dataclass(frozen=True)
class OnDelta:
    """An effect hidden in a delta robot of another plant, compared on the motion that was not fitted."""

    expected: str
    effect: str
    size: float
    seed: int

    def sentence(self) -> str:
        """First sentence of `ident compare`."""
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            make(folder, [self.effect], [self.size], self.seed, Setting())
            model = ident.fit([folder / TRAIN], method="wls")
            return ident.compare(model, [folder / VALIDATE]).sentences[0]


def _ripple(order: float) -> Torque:
    return lambda motion, time: np.sin(order * motion.position[:, 0])


def _delayed(motion: Motion, time: Floats) -> Floats:
    torque = building.INERTIA * motion.acceleration[:, 0] + building.VISCOUS * motion.velocity[:, 0]
    return np.gradient(torque, time)


def _load(motion: Motion) -> Floats:
    return np.abs(building.INERTIA * motion.acceleration[:, 0])


CASES: tuple[OnAxes | OnDelta, ...] = (
    OnAxes("wave over its position", _ripple(14), 0.5, 1),
    OnAxes("wave over its position", _ripple(7), 0.15, 2),
    OnAxes("over its position", lambda motion, time: motion.position[:, 0], 1.0, 3),
    OnAxes("over its position", lambda motion, time: motion.position[:, 0] ** 3, 0.5, 4),
    OnAxes("over its velocity", lambda motion, time: motion.velocity[:, 0] * np.abs(motion.velocity[:, 0]), 2.0, 5),
    OnAxes(
        "over its velocity",
        lambda motion, time: np.exp(-((motion.velocity[:, 0] / 0.3) ** 2)) * motion.direction[:, 0],
        0.4,
        6,
    ),
    OnAxes("over its velocity", lambda motion, time: np.abs(motion.velocity[:, 0]), 0.5, 7),
    OnAxes("computed load, reversed with", lambda motion, time: _load(motion) * motion.direction[:, 0], 1.0, 8),
    OnAxes("over its acceleration", lambda motion, time: motion.acceleration[:, 0], 0.5, 9, parameter=True),
    OnAxes("over the time", lambda motion, time: time, 0.5, 10),
    OnAxes("over the time, reversed with", lambda motion, time: np.exp(-time / 5) * motion.direction[:, 0], 1.0, 11),
    OnAxes("rate of change of its computed load", _delayed, 0.5, 12),
    OnAxes("over joint 2's acceleration", lambda motion, time: motion.acceleration[:, 1], 0.4, 13),
    OnAxes("over joint 2's position", lambda motion, time: np.cos(motion.position[:, 1]), 0.4, 14),
    OnAxes(
        "over its position, reversed with",
        lambda motion, time: motion.position[:, 0] * motion.direction[:, 0],
        0.4,
        15,
    ),
    OnDelta("over its position", "cogging", 0.05, 1),
    OnDelta("over its position", "joint_spring", 0.05, 2),
    OnDelta("over its velocity", "stribeck", 0.05, 3),
    OnDelta("over its velocity", "asymmetric_viscous", 0.05, 4),
    OnDelta("rate of change of its computed load", "actuation_delay", 0.05, 5),
)


def misses(cases: tuple[OnAxes | OnDelta, ...] = CASES) -> Iterator[tuple[OnAxes | OnDelta, str]]:
    """Yield the cases whose first sentence does not name the variable, with that sentence."""
    for case in cases:
        sentence = case.sentence()
        if case.expected not in sentence:
            yield case, sentence


@click.command()
def main() -> None:
    """Print in how many of the recordings the first sentence names the variable, and the others."""
    missed = list(misses())
    click.echo(f"{len(CASES) - len(missed)} of {len(CASES)}")
    for case, sentence in missed:
        click.echo(f"{case}: {sentence}")


if __name__ == "__main__":
    main()
