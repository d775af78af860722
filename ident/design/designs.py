"""The two designs: for the accuracy of all parameters, and for the discrimination of effects."""

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
    """Requirements of the motion to design."""

    name: str
    """Name of the trajectory file."""
    rig: Rig
    period: float
    """[s]"""
    harmonics: int
    against: str | None
    """Trajectory for comparison; None: the built-in excitation, for a delta robot."""
    noise: float
    """RMS noise of the torque [N m or N]."""
    seed: int

    @property
    def reference(self) -> Trajectory | None:
        """Trajectory for comparison; None if there is none."""
        against = self.against or ("excitation" if self.rig.mechanism == "delta" else None)
        return load(against, self.rig) if against else None


@dataclass(frozen=True, eq=False)
class DesignResult:
    """Quality of a designed motion, compared with an existing motion."""

    name: str
    """Name of the trajectory file."""
    criterion: str
    seed: int
    noise: float
    """RMS noise of the torque [N m or N]."""
    seconds: float
    """Duration of the repeated motion."""
    parameters: tuple[Parameter, ...]
    after: Quality
    """Quality of the designed motion."""
    against: str | None
    """Name of the existing motion."""
    before: Quality | None
    """Quality of the existing motion."""


Design = tuple[DesignResult, FourierSeries]


def design_excitation(
    request: DesignRequest, mechanism: Mechanism, criterion: Criterion, progress: Progress
) -> Design:
    """Design the motion from which the parameters of the `mechanism` are identified best.

    Raises:
        BadInput: there is no motion within the limits.
    """
    reference = request.reference
    before = motion_quality(reference, request.rig, mechanism, request.noise, DEFAULT_CUTOFF) if reference else None
    against = request.against or (reference.name if reference else None)
    return _design(request, mechanism, criterion, against, before, progress)


def design_discrimination(
    request: DesignRequest,
    pairs: Sequence[Pair],
    effects: Mapping[str, Effect],
    joints: Sequence[int],
    recorded: Sequence[RecordedMotion],
    progress: Progress,
) -> Design:
    """Design the motion that, together with the `recorded` ones, discriminates the effects of all `pairs` best.

    effects: by name.
    joints: possible joints of the true effect, from 0; empty: all.

    Raises:
        BadInput: an effect is not of this mechanism, depends on time, or is not observable in recordings of this rig;
            or no motion discriminates the effects.
    """
    first = recorded[0] if recorded else None
    parameters, torque_measured = (first.parameters, first.torque_measured) if first else (None, False)
    mechanism = discrimination_model(request.rig, pairs, effects, joints, parameters, torque_measured=torque_measured)
    reference = recorded[0].trajectory if recorded else request.reference or _random_trajectory(request, mechanism)
    mechanism = mechanism.at_rate(reference.rate).normalized_on(repeated_motion(reference))
    for motion in recorded[1:]:
        mechanism = mechanism.at_rate(motion.trajectory.rate).with_recorded(repeated_motion(motion.trajectory))
    before = motion_quality(reference, request.rig, mechanism, request.noise, DEFAULT_CUTOFF)
    against = reference.name if recorded else request.against or reference.name
    if recorded:
        mechanism = mechanism.at_rate(reference.rate).with_recorded(repeated_motion(reference))
    outcome, series = _design(request, mechanism, "t", against, before, progress)
    discriminability = outcome.after.discriminability or {}
    weakest = min(discriminability, key=lambda name: discriminability[name])
    if discriminability[weakest] < MIN_DISCRIMINABILITY:
        raise BadInput(
            "effects that can be discriminated by a motion expected; with the best motion found, another effect "
            f"explains all but {100 * discriminability[weakest]:.1g} % of {weakest}; inspect the machine itself"
        )
    return outcome, series


def _random_trajectory(request: DesignRequest, mechanism: Mechanism) -> Trajectory:
    generator = np.random.default_rng(request.seed)
    series = random_motion(request.rig, mechanism, request.period, request.harmonics, generator)
    return assemble(series.motion("a random motion"), request.rig)


def _design(
    request: DesignRequest,
    mechanism: Mechanism,
    criterion: Criterion,
    against: str | None,
    before: Quality | None,
    progress: Progress,
) -> Design:
    generator = np.random.default_rng(request.seed)
    series = search(request.rig, mechanism, criterion, request.period, request.harmonics, generator, progress)
    after = assemble(series.motion(request.name), request.rig)
    outcome = DesignResult(
        name=request.name,
        criterion=criterion,
        seed=request.seed,
        noise=request.noise,
        seconds=after.cycles * after.period,
        parameters=mechanism.parameters,
        after=motion_quality(after, request.rig, mechanism, request.noise, DEFAULT_CUTOFF),
        against=against,
        before=before,
    )
    return outcome, series
