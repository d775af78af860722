"""The two designs: the motion that shows all parameters best, and the one that tells effects apart best."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ident.data.cutoff import DEFAULT_CUTOFF
from ident.design.discrimination import LEAST, Pair, rivals
from ident.design.motions import repeated
from ident.design.problem import Criterion
from ident.design.quality import Quality, judge
from ident.design.recorded import Recorded
from ident.design.search import drawn, search
from ident.dynamics.effects.base import Effect
from ident.dynamics.mechanisms import Mechanism, Parameter
from ident.estimation.problem import Progress
from recordings.errors import BadInput
from recordings.rig import Rig
from trajectories import Trajectory, load
from trajectories.fourier import FourierSeries
from trajectories.trajectory import assemble


@dataclass(frozen=True)
class Order:
    """What the motion is to be like."""

    name: str
    """Of the trajectory file."""
    rig: Rig
    period: float
    """[s]"""
    harmonics: int
    against: str | None
    """Trajectory that it is compared with; None: the built-in excitation, for a delta robot."""
    noise: float
    """RMS of the torque [N m or N]."""
    seed: int

    @property
    def compared(self) -> Trajectory | None:
        """What it is compared with."""
        against = self.against or ("excitation" if self.rig.mechanism == "delta" else None)
        return load(against, self.rig) if against else None


@dataclass(frozen=True, eq=False)
class Outcome:
    """A designed motion, beside one that is there already."""

    name: str
    """Of the trajectory file."""
    criterion: str
    seed: int
    noise: float
    """RMS of the torque [N m or N]."""
    seconds: float
    """Of the repeated motion."""
    parameters: tuple[Parameter, ...]
    after: Quality
    against: str | None
    """Name of the motion it is compared with."""
    before: Quality | None


Found = tuple[Outcome, FourierSeries]


def excitation(order: Order, mechanism: Mechanism, criterion: Criterion, progress: Progress) -> Found:
    """The motion that shows the parameters of the `mechanism` best.

    Raises:
        BadInput: there is no motion within the limits.
    """
    reference = order.compared
    before = judge(reference, order.rig, mechanism, order.noise, DEFAULT_CUTOFF) if reference else None
    against = order.against or (reference.name if reference else None)
    return _found(order, mechanism, criterion, against, before, progress)


def discrimination(
    order: Order,
    pairs: Sequence[Pair],
    effects: Mapping[str, Effect],
    joints: Sequence[int],
    recorded: Sequence[Recorded],
    progress: Progress,
) -> Found:
    """The motion that tells the effects of each of the `pairs` apart best, together with what is `recorded`.

    effects: by name; joints: on which the true one is, from 0, or anywhere if empty.

    Raises:
        BadInput: an effect is none of this mechanism, depends on time, or leaves no trace in recordings of this rig;
            or no motion tells them apart.
    """
    first = recorded[0] if recorded else None
    known, torque_measured = (first.known, first.torque_measured) if first else (None, False)
    mechanism = rivals(order.rig, pairs, effects, joints, known, torque_measured=torque_measured)
    reference = recorded[0].trajectory if recorded else order.compared or _random(order, mechanism)
    mechanism = mechanism.sampled(reference.rate).as_strong_as_on(repeated(reference))
    for other in recorded[1:]:
        mechanism = mechanism.sampled(other.trajectory.rate).beside(repeated(other.trajectory))
    before = judge(reference, order.rig, mechanism, order.noise, DEFAULT_CUTOFF)
    against = reference.name if recorded else order.against or reference.name
    if recorded:
        mechanism = mechanism.sampled(reference.rate).beside(repeated(reference))
    outcome, series = _found(order, mechanism, "t", against, before, progress)
    told = outcome.after.told_apart or {}
    least = min(told, key=lambda name: told[name])
    if told[least] < LEAST:
        raise BadInput(
            f"effects that some motion tells apart expected, in the best one found a rival imitates all but "
            f"{100 * told[least]:.1g} % of {least}; look at the machine itself"
        )
    return outcome, series


def _random(order: Order, mechanism: Mechanism) -> Trajectory:
    generator = np.random.default_rng(order.seed)
    series = drawn(order.rig, mechanism, order.period, order.harmonics, generator)
    return assemble(series.motion("a random motion"), order.rig)


def _found(
    order: Order,
    mechanism: Mechanism,
    criterion: Criterion,
    against: str | None,
    before: Quality | None,
    progress: Progress,
) -> Found:
    generator = np.random.default_rng(order.seed)
    series = search(order.rig, mechanism, criterion, order.period, order.harmonics, generator, progress)
    after = assemble(series.motion(order.name), order.rig)
    outcome = Outcome(
        name=order.name,
        criterion=criterion,
        seed=order.seed,
        noise=order.noise,
        seconds=after.cycles * after.period,
        parameters=mechanism.parameters,
        after=judge(after, order.rig, mechanism, order.noise, DEFAULT_CUTOFF),
        against=against,
        before=before,
    )
    return outcome, series
