"""The two designs: the motion that shows all parameters best, and the one that tells effects apart best."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ident.data.cutoff import DEFAULT_CUTOFF
from ident.design.discrimination import MIN_DISCRIMINABILITY, Pair, discrimination_model
from ident.design.motions import repeated_motion
from ident.design.problem import Criterion
from ident.design.quality import Quality, motion_quality
from ident.design.recorded import RecordedMotion
from ident.design.search import random_motion, search
from ident.dynamics.effects.base import Effect
from ident.dynamics.mechanisms import Mechanism, Parameter
from ident.estimation.problem import Progress
from recordings.errors import BadInput
from recordings.rig import Rig
from trajectories import Trajectory, load
from trajectories.fourier import FourierSeries
from trajectories.trajectory import assemble


@dataclass(frozen=True)
class DesignRequest:
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
    def reference(self) -> Trajectory | None:
        """What it is compared with."""
        against = self.against or ("excitation" if self.rig.mechanism == "delta" else None)
        return load(against, self.rig) if against else None


@dataclass(frozen=True, eq=False)
class DesignResult:
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


Design = tuple[DesignResult, FourierSeries]


def design_excitation(request: DesignRequest, mechanism: Mechanism, criterion: Criterion, progress: Progress) -> Design:
    """The motion that shows the parameters of the `mechanism` best.

    Raises:
        BadInput: there is no motion within the limits.
    """
    reference = request.reference
    before = motion_quality(reference, request.rig, mechanism, request.noise, DEFAULT_CUTOFF) if reference else None
    against = request.against or (reference.name if reference else None)
    return _found(request, mechanism, criterion, against, before, progress)


def design_discrimination(
    request: DesignRequest,
    pairs: Sequence[Pair],
    effects: Mapping[str, Effect],
    joints: Sequence[int],
    recorded: Sequence[RecordedMotion],
    progress: Progress,
) -> Design:
    """The motion that tells the effects of each of the `pairs` apart best, together with what is `recorded`.

    effects: by name; joints: on which the true one is, from 0, or anywhere if empty.

    Raises:
        BadInput: an effect is none of this mechanism, depends on time, or leaves no trace in recordings of this rig;
            or no motion tells them apart.
    """
    first = recorded[0] if recorded else None
    known, torque_measured = (first.parameters, first.torque_measured) if first else (None, False)
    mechanism = discrimination_model(request.rig, pairs, effects, joints, known, torque_measured=torque_measured)
    reference = recorded[0].trajectory if recorded else request.reference or _random(request, mechanism)
    mechanism = mechanism.at_rate(reference.rate).normalized_on(repeated_motion(reference))
    for other in recorded[1:]:
        mechanism = mechanism.at_rate(other.trajectory.rate).with_recorded(repeated_motion(other.trajectory))
    before = motion_quality(reference, request.rig, mechanism, request.noise, DEFAULT_CUTOFF)
    against = reference.name if recorded else request.against or reference.name
    if recorded:
        mechanism = mechanism.at_rate(reference.rate).with_recorded(repeated_motion(reference))
    outcome, series = _found(request, mechanism, "t", against, before, progress)
    told = outcome.after.discriminability or {}
    least = min(told, key=lambda name: told[name])
    if told[least] < MIN_DISCRIMINABILITY:
        raise BadInput(
            f"effects that some motion tells apart expected, in the best one found a rival imitates all but "
            f"{100 * told[least]:.1g} % of {least}; look at the machine itself"
        )
    return outcome, series


def _random(order: DesignRequest, mechanism: Mechanism) -> Trajectory:
    generator = np.random.default_rng(order.seed)
    series = random_motion(order.rig, mechanism, order.period, order.harmonics, generator)
    return assemble(series.motion("a random motion"), order.rig)


def _found(
    order: DesignRequest,
    mechanism: Mechanism,
    criterion: Criterion,
    against: str | None,
    before: Quality | None,
    progress: Progress,
) -> Design:
    generator = np.random.default_rng(order.seed)
    series = search(order.rig, mechanism, criterion, order.period, order.harmonics, generator, progress)
    after = assemble(series.motion(order.name), order.rig)
    outcome = DesignResult(
        name=order.name,
        criterion=criterion,
        seed=order.seed,
        noise=order.noise,
        seconds=after.cycles * after.period,
        parameters=mechanism.parameters,
        after=motion_quality(after, order.rig, mechanism, order.noise, DEFAULT_CUTOFF),
        against=against,
        before=before,
    )
    return outcome, series
