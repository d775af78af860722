"""A recording that is preprocessed once, so that the torque of many models can be predicted from it."""

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
    """Motion (n instants) and mechanism after correction of encoder and geometry errors."""

    rig: Rig
    motion: Motion
    mechanism: Mechanism

    @cached_property
    def regressor(self) -> Floats:
        """(n, dof, k) columns of the mechanism's own parameters."""
        return self.mechanism.regressor(self.motion)

    def effect_inputs(self, rate: float, time: Floats, bandwidth: float, load_parameters: Floats) -> EffectInputs:
        """Inputs of effects.

        rate: instants per second [Hz]. time: (n,) [s]. bandwidth: of the analysis [Hz].
        load_parameters: (k or k + 1,) of a model structure.
        """
        parameters, m_d = (
            load_parameters[: len(self.mechanism.parameters)],
            float(load_parameters[len(self.mechanism.parameters) :].sum()),
        )
        rigid = np.array([not parameter.friction for parameter in self.mechanism.parameters])
        rigid_parameters = np.where(rigid, parameters, 0.0)

        def rigid_at(motion: Motion) -> Floats:
            regressor = self.regressor if motion is self.motion else self.mechanism.regressor(motion)
            torque: Floats = regressor @ rigid_parameters
            return torque + m_d * rods.torque(self.rig.geometry, motion) if m_d else torque

        by_name = {
            parameter.name: float(x) for parameter, x in zip(self.mechanism.parameters, parameters, strict=True)
        }
        by_name["m_d"] = m_d
        return EffectInputs(self.rig, rate, time, self.motion, rigid_at, bandwidth, by_name)


@dataclass(frozen=True, eq=False)
class PreparedRecording:
    """A recording with its samples, filters and measured torque."""

    samples: Samples
    preprocessed: Preprocessed
    dataset: Dataset
    method: str
    as_recorded: CorrectedMotion
    """Motion and mechanism without corrections, from the recording and its rig file."""
    start: float = 0.0
    """Start on the time axis of effects [s]; not 0 for an excerpt of a longer recording."""

    @property
    def recording(self) -> Recording:
        """The underlying recording."""
        return self.dataset.recording

    @cached_property
    def time(self) -> Floats:
        """(n,) time of the instants [s]."""
        seconds: Floats = self.start + self.preprocessed.instants / self.samples.rate
        return seconds

    @cached_property
    def usable(self) -> Bools:
        """(m, dof) True for usable rows."""
        return np.isfinite(self.dataset.torque)

    def condition(self, x: Floats) -> Floats:
        """Filter and decimate `x` (n, ...) in the same way as the torque: (m, ...)."""
        return self.preprocessed.condition(x)

    def corrected_motion(self, rig: Rig, correct: Callable[[Floats], Floats]) -> CorrectedMotion:
        """Motion and mechanism for a corrected `rig` and positions corrected by `correct`."""
        samples = replace(self.samples, position=correct(self.samples.position))
        motion = preprocessing.load(self.method)(samples, self.preprocessed.bandwidth).motion
        return CorrectedMotion(rig, motion, mechanisms.create(rig))


def prepare(recording: Recording, method: str, cutoff: float | None, start: float = 0.0) -> PreparedRecording:
    """Preprocess `recording`, which begins at `start` [s], by `method`.

    cutoff: [Hz]; None: chosen by the method.

    Raises:
        BadInput: as `ident.data.dataset.build`.
    """
    samples = sample(recording)
    mechanism = mechanisms.create(recording.rig)
    try:
        preprocessed = preprocessing.load(method)(samples, cutoff)
        dataset = assemble(recording, samples, preprocessed, mechanism)
    except BadInput as error:
        raise BadInput(f"{recording.path.name}: {error}") from None
    dataset = replace(dataset, time=dataset.time + start)
    return PreparedRecording(
        samples, preprocessed, dataset, method, CorrectedMotion(recording.rig, preprocessed.motion, mechanism), start
    )
