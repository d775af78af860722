"""One recording, prepared once, from which the torque of any model is computed again and again."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ident.data import preprocessing
from ident.data.dataset import Dataset, assemble
from ident.data.preprocessing import Preprocessed
from ident.data.samples import Samples, sample
from ident.dynamics import mechanisms, rods
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.mechanisms import Mechanism
from ident.dynamics.motion import Motion
from recordings.errors import BadInput
from recordings.recording import Bools, Floats, Recording
from recordings.rig import Rig


@dataclass(frozen=True, eq=False)
class CorrectedMotion:
    """What the machine did, as its encoders and its rig file say once they are corrected: n instants."""

    rig: Rig
    motion: Motion
    mechanism: Mechanism

    @cached_property
    def regressor(self) -> Floats:
        """(n, dof, k) columns of the mechanism's own parameters."""
        return self.mechanism.regressor(self.motion)

    def effect_inputs(self, course: "PreparedRecording", load: Floats) -> EffectInputs:
        """What effects see of it, with the `load` of a composition (k or k + 1,)."""
        parameters, m_d = load[: len(self.mechanism.parameters)], float(load[len(self.mechanism.parameters) :].sum())
        rigid = np.array([not parameter.friction for parameter in self.mechanism.parameters])
        known = np.where(rigid, parameters, 0.0)

        def rigid_at(motion: Motion) -> Floats:
            regressor = self.regressor if motion is self.motion else self.mechanism.regressor(motion)
            torque: Floats = regressor @ known
            return torque + m_d * rods.torque(self.rig.geometry, motion) if m_d else torque

        by_name = {one.name: float(x) for one, x in zip(self.mechanism.parameters, parameters, strict=True)}
        by_name["m_d"] = m_d
        rate, bandwidth = course.samples.rate, course.preprocessed.bandwidth
        return EffectInputs(self.rig, rate, course.time, self.motion, rigid_at, bandwidth, by_name)


@dataclass(frozen=True, eq=False)
class PreparedRecording:
    """A recording with its samples, filters and measured torque."""

    samples: Samples
    preprocessed: Preprocessed
    dataset: Dataset
    method: str
    as_recorded: CorrectedMotion
    """As the recording and its rig file have it."""
    start: float = 0.0
    """On the clock that effects see [s]: not 0 for a part of a longer recording."""

    @property
    def recording(self) -> Recording:
        """Where all of it is from."""
        return self.dataset.recording

    @cached_property
    def time(self) -> Floats:
        """(n,) of the motion's instants [s]."""
        seconds: Floats = self.start + self.preprocessed.instants / self.samples.rate
        return seconds

    @cached_property
    def usable(self) -> Bools:
        """(m, dof) which rows count."""
        return np.isfinite(self.dataset.torque)

    def condition(self, x: Floats) -> Floats:
        """`x` (n, ...) filtered and decimated as the torque was: (m, ...)."""
        return self.preprocessed.condition(x)

    def corrected_motion(self, rig: Rig, position: Callable[[Floats], Floats]) -> CorrectedMotion:
        """The path if the rig were `rig`, and the encoders' angles what `position` makes of those recorded."""
        samples = replace(self.samples, position=position(self.samples.position))
        motion = preprocessing.load(self.method)(samples, self.preprocessed.bandwidth).motion
        return CorrectedMotion(rig, motion, mechanisms.create(rig))


def prepare(recording: Recording, method: str, cutoff: float | None, start: float = 0.0) -> PreparedRecording:
    """Preprocess `recording`, which begins at `start` [s], by `method` at `cutoff` [Hz], or the method's own.

    Raises:
        BadInput: as `ident.data.dataset.build`.
    """
    samples = sample(recording)
    mechanism = mechanisms.create(recording.rig)
    try:
        prepared = preprocessing.load(method)(samples, cutoff)
        dataset = assemble(recording, samples, prepared, mechanism)
    except BadInput as error:
        raise BadInput(f"{recording.path.name}: {error}") from None
    dataset = replace(dataset, time=dataset.time + start)
    return PreparedRecording(samples, prepared, dataset, method, CorrectedMotion(recording.rig, prepared.motion, mechanism), start)
