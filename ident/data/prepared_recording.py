"""A recording, preprocessed once, so that the torque of many models can be compared with the measured one."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, cast

import numpy as np

from ident.basics import slicing
from ident.data import preprocessing
from ident.data.cutoff import Cutoff, choose_common, given_or_chosen
from ident.data.gaps import across_gaps
from ident.data.preprocessing import Preprocessed
from ident.data.samples import Samples, drive_signal, sample
from ident.dynamics import mechanisms
from ident.dynamics.mechanism_motion import MechanismMotion
from ident.dynamics.mechanisms import RigidMechanism, torque_of_masses
from ident.dynamics.mechanisms.urdf import Urdf
from ident.dynamics.motion import Motion
from ident.dynamics.structure import ModelStructure
from recordings.errors import BadInput
from recordings.pickling import WithoutCaches
from recordings.recording import Bools, Floats, Ints, Recording
from recordings.resolution import resolution
from recordings.rig import Rig

BLOCK = 4096
"""Conditioned samples computed at a time."""
MIN_ROWS_PER_PARAMETER = 10
"""Usable samples, of all joints, per parameter below which nothing is fitted."""
MAX_CYCLE = 4.0
"""Maximum duration of the excerpt shown in figures [s]."""


@dataclass(frozen=True, eq=False)
class PreparedRecording(WithoutCaches):
    """A recording as every model reads it: motion at n instants, and m rows of the torque, filtered and decimated."""

    recording: Recording
    method: str
    """Preprocessing."""
    mechanism: RigidMechanism
    """Of the rig, or the form of it that is identified."""
    samples: Samples
    preprocessed: Preprocessed
    regressor: Floats
    """(m, dof, k) columns of the mechanism, conditioned as the torque."""
    torque: Floats
    """(m, dof) measured torque [N m] without that of the masses beyond the payload; NaN where a row is not usable."""
    start: float = 0.0
    """Start on the time axis of effects [s]; not 0 for an excerpt of a longer recording."""
    end: float | None = None
    """End of that longer recording on the same axis [s]; None: this is no excerpt."""
    moved: bool = False
    """Whether the positions are not the recorded ones, of which the `regressor` is."""
    form: str | None = None
    """That of the mechanism."""

    def __reduce__(self) -> Any:
        """Pickle the recording and how it is prepared, which is done again; with other positions, the fields."""
        if self.moved:
            return super().__reduce__()
        fields = (self.recording, self.method, self.cutoff, self.start, self.end, self.form)
        return prepare, (*fields, isinstance(self.mechanism, Urdf) and self.mechanism.bound_to_bodies)

    def bound_to_bodies(self) -> "PreparedRecording":
        """Return the recording of a tree of links that fits allow to be bodies alone."""
        assert isinstance(self.mechanism, Urdf)
        return replace(self, mechanism=replace(self.mechanism, bound_to_bodies=True))

    @cached_property
    def as_recorded(self) -> MechanismMotion:
        """Motion and mechanism without corrections, from the recording and its rig file."""
        motion = self.preprocessed.motion
        return MechanismMotion(self.recording.rig, motion, self.mechanism, self.recording.beyond, recorded=True)

    @cached_property
    def base_structure(self) -> ModelStructure:
        """The mechanism without effects."""
        return ModelStructure(self.mechanism, self.recording.rig)

    @cached_property
    def instant_time(self) -> Floats:
        """(n,) time of the instants [s]."""
        return self.start + self.preprocessed.instants / self.samples.rate

    @cached_property
    def temperature(self) -> Floats:
        """(n, dof) temperature of the drives [degC]."""
        return self.samples.temperature[self.preprocessed.instants]

    @cached_property
    def drive_step(self) -> Floats:
        """(dof,) step of what the drives report [V], or of the effort [N m or N]."""
        return _steps(drive_signal(self.recording))

    @cached_property
    def encoder_step(self) -> Floats:
        """(dof,) step of the encoders [rad or m]."""
        return _steps(self.samples.position)

    @cached_property
    def time(self) -> Floats:
        """(m,) time of the rows, from the recording's first SYNC [s]."""
        return self.instant_time[:: self.preprocessed.decimation]

    @cached_property
    def motion(self) -> Motion:
        """(m, dof) motion at the rows, for the analysis of residuals."""
        return slicing.along_time(self.preprocessed.motion, slice(None, None, self.preprocessed.decimation))

    @cached_property
    def repeat(self) -> Ints:
        """(m,) index of the cycle; -1 outside of the repeated motion."""
        return self.samples.repeat[self._sample_of_row]

    @cached_property
    def phase(self) -> Floats:
        """(m,) time since the beginning of the cycle [s]; NaN outside of the repeated motion."""
        return self.samples.phase[self._sample_of_row]

    @property
    def rate(self) -> float:
        """Rows per second [Hz]."""
        return self.preprocessed.rate

    @property
    def bandwidth(self) -> float:
        """Of the torque [Hz]."""
        return self.preprocessed.bandwidth

    @property
    def cutoff(self) -> Cutoff | None:
        """How the bandwidth was chosen; None if the method has no cut-off."""
        return self.preprocessed.cutoff

    @property
    def volt_sensitivity(self) -> Floats:
        """(m, dof) torque noise per noise in the measured voltage, both after preprocessing [N m/V]."""
        return self.preprocessed.sensitivity

    @cached_property
    def usable(self) -> Bools:
        """(m, dof) True for usable rows."""
        return np.isfinite(self.torque)

    @cached_property
    def nominal(self) -> Floats | None:
        """(m, dof) torque of the manufacturer's model [N m], where there is one."""
        if self.mechanism.nominal_torque(slicing.along_time(self.preprocessed.motion, slice(1))) is None:
            return None
        return _in_blocks(self.preprocessed, cast(Callable[[Motion], Floats], self.mechanism.nominal_torque))

    @property
    def first_cycle(self) -> slice:
        """Rows of the first usable cycle: one period of the motion, at most MAX_CYCLE seconds."""
        seconds = min(self.recording.run.period or MAX_CYCLE, MAX_CYCLE)
        first = int(np.argmax(self.usable.any(axis=1)))
        return slice(first, first + int(seconds * self.rate) + 1)

    def condition(self, x: Floats) -> Floats:
        """Filter and decimate `x` (n, ...) in the same way as the torque: (m, ...)."""
        return self.preprocessed.condition(x)

    def columns(self, at: MechanismMotion) -> Floats:
        """(m, dof, k) columns of a mechanism in this or a corrected motion, conditioned as the torque."""
        if at is self.as_recorded and not self.moved:
            return self.regressor
        return _in_blocks(replace(self.preprocessed, motion=at.motion), at.mechanism.regressor)

    def corrected_motion(self, rig: Rig, correct: Callable[[Floats], Floats]) -> MechanismMotion:
        """Motion and mechanism for a corrected `rig` and positions corrected by `correct`."""
        motion = self.with_positions(correct).preprocessed.motion
        return MechanismMotion(rig, motion, mechanisms.create(rig), self.recording.beyond)

    def with_positions(self, correct: Callable[[Floats], Floats]) -> "PreparedRecording":
        """Return the recording with positions corrected by `correct`, and the same rows of the torque."""
        samples = replace(self.samples, position=correct(self.samples.position))
        motion = preprocessing.load(self.method)(samples, self.cutoff).motion
        return replace(self, samples=samples, preprocessed=replace(self.preprocessed, motion=motion), moved=True)

    @property
    def _sample_of_row(self) -> Ints:
        return self.preprocessed.instants[:: self.preprocessed.decimation]


def _steps(signal: Floats) -> Floats:
    """(dof,) step of the readings in `signal` (n, dof); 0 where they are continuous."""
    return np.array([resolution(readings) or 0.0 for readings in signal.T])


def prepare(
    recording: Recording,
    method: str,
    cutoff: float | Cutoff | None,
    start: float = 0.0,
    end: float | None = None,
    form: str | None = None,
    bound_to_bodies: bool = False,
) -> PreparedRecording:
    """Preprocess `recording`, which begins at `start` [s] of a longer one that ends at `end` [s], by `method`.

    Only the repeated motion is used, if the recording has one. Approach and stop serve as run-in of the filters.

    cutoff: [Hz], or as chosen for several recordings; None: chosen by the method.
    form: another linear model of the mechanism. bound_to_bodies: as `PreparedRecording.bound_to_bodies`.

    Raises:
        BadInput: the recording contains no usable data, the method does not accept the cut-off, or the mechanism
            cannot be assembled at its angles.
    """
    samples = sample(recording)
    known = samples.known
    chosen = None if cutoff is None and method in preprocessing.WITHOUT_CUTOFF else given_or_chosen(cutoff, samples)
    gap = chosen.gap if chosen else 0.0
    samples = sample(recording, gap) if gap else samples
    mechanism = mechanisms.create(recording.rig, form)
    try:
        preprocessed = preprocessing.load(method)(samples, chosen)
        preprocessed = across_gaps(preprocessed, samples, known) if gap else preprocessed
        regressor = _in_blocks(preprocessed, mechanism.regressor)
        torque = _usable_torque(recording, samples, preprocessed, regressor)
        if recording.beyond:
            torque = torque - _in_blocks(preprocessed, partial(torque_of_masses, mechanism, recording.beyond))
    except BadInput as error:
        raise BadInput(f"{recording.path.name}: {error}") from None
    prepared = PreparedRecording(
        recording, method, mechanism, samples, preprocessed, regressor, torque, start, end, form=form
    )
    return prepared.bound_to_bodies() if bound_to_bodies else prepared


def prepare_all(
    recordings: Sequence[Recording], method: str, cutoff: float | None, form: str | None = None
) -> tuple[PreparedRecording, ...]:
    """Prepare several recordings with a common bandwidth, that of a `cutoff` [Hz] or of the `common_cutoff`.

    Raises:
        BadInput: as `prepare`.
    """
    common = common_cutoff(recordings, method) if cutoff is None else cutoff
    return tuple(prepare(recording, method, common, form=form) for recording in recordings)


def common_cutoff(recordings: Sequence[Recording], method: str) -> Cutoff | None:
    """The cut-off that is chosen for all `recordings` together; None if the method has none."""
    return None if method in preprocessing.WITHOUT_CUTOFF else choose_common(recordings)


def _in_blocks(preprocessed: Preprocessed, columns: Callable[[Motion], Floats]) -> Floats:
    """Compute `columns` of the motion and condition them: (m, ...).

    Columns of a long recording at full rate do not fit into memory. They depend only on the motion at the same
    instant, so they are computed in blocks, each padded by the half-width of the filter.
    """
    n, step, half_width = len(preprocessed.motion.position), preprocessed.decimation, preprocessed.half_width
    if half_width is None:
        return preprocessed.condition(columns(preprocessed.motion))
    before = -(-half_width // step)
    result: Floats | None = None  # concatenating the blocks would take twice the memory
    for first in range(0, n, BLOCK * step):
        start = max(0, first - before * step)
        motion = slicing.along_time(preprocessed.motion, slice(start, first + BLOCK * step + half_width))
        conditioned = preprocessed.condition(columns(motion))
        offset, row = (first - start) // step, first // step
        if result is None:
            result = np.empty((-(-n // step), *conditioned.shape[1:]))
        result[row : row + BLOCK] = conditioned[offset : offset + BLOCK]
    assert result is not None  # there are samples
    return result


def _usable_torque(recording: Recording, samples: Samples, preprocessed: Preprocessed, regressor: Floats) -> Floats:
    """(m, dof) measured torque; NaN in rows that are not usable."""
    selected = samples.selected[preprocessed.instants[:: preprocessed.decimation], None]
    usable = np.isfinite(preprocessed.torque) & np.isfinite(regressor).all(axis=2) & selected
    dof, parameters = regressor.shape[1:]
    expected, count = -(-MIN_ROWS_PER_PARAMETER * parameters // dof), int(usable.sum(axis=0).min())
    if count < expected:
        cut_off = "" if recording.complete else "; the file is cut off"
        raise BadInput(
            f"at least {expected} usable samples per joint expected after preprocessing, "
            f"{count} of {len(recording.time)} recorded ones found{cut_off}; record longer or with fewer gaps"
        )
    return np.where(usable, preprocessed.torque, np.nan)
