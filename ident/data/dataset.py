"""Convert a recording to rows for an estimator: the usable samples of its motion and their regressor."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import cast

import numpy as np

from ident.data import preprocessing
from ident.data.cutoff import Cutoff
from ident.data.preprocessing import Preprocessed
from ident.data.samples import Samples, sample
from ident.dynamics.mechanisms import Mechanism
from ident.dynamics.motion import Motion
from recordings.errors import BadInput
from recordings.recording import Floats, Ints, Recording

BLOCK = 4096
"""Conditioned samples computed at a time."""
MIN_ROWS_PER_PARAMETER = 10
"""Usable samples per parameter below which nothing is fitted."""
MAX_CYCLE = 4.0
"""Maximum duration of the excerpt shown in figures [s]."""


@dataclass(frozen=True, eq=False)
class Dataset:
    """m preprocessed samples of dof joints. The torque is NaN where a sample is not usable."""

    recording: Recording
    time: Floats
    """(m,) from the recording's first SYNC [s]."""
    motion: Motion
    """(m, dof), for the analysis of residuals; the regressor was computed from the motion at full rate."""
    regressor: Floats
    """(m, dof, k)."""
    torque: Floats
    """(m, dof) measured torque [N m]."""
    nominal: Floats | None
    """(m, dof) torque of the manufacturer's model [N m], where there is one."""
    volt_sensitivity: Floats
    """(m, dof) torque noise per noise in the measured voltage, both after preprocessing [N m/V]."""
    repeat: Ints
    """(m,) index of the cycle; -1 outside of the repeated motion."""
    phase: Floats
    """(m,) time since the beginning of the cycle [s]; NaN outside of the repeated motion."""
    rate: float
    """Samples per second [Hz]."""
    bandwidth: float
    """[Hz]."""
    cutoff: Cutoff | None
    """How the bandwidth was chosen; None if the method has no cut-off."""
    offset: Floats | None = None
    """(m, dof) predicted torque that does not depend on the parameters [N m]; None: zero."""

    def rows(self) -> tuple[Floats, Floats]:
        """Regressor (r, k) and torque (r,) of the usable samples, one joint after the other."""
        usable = np.isfinite(self.torque).T
        torque = self.torque if self.offset is None else self.torque - self.offset
        return self.regressor.swapaxes(0, 1)[usable], torque.T[usable]

    def predicted_torque(self, parameters: Floats) -> Floats:
        """Torque (m, dof) [N m] predicted with `parameters` (k,)."""
        predicted: Floats = self.regressor @ parameters
        return predicted if self.offset is None else predicted + self.offset


def first_cycle(dataset: Dataset) -> slice:
    """Rows of the first usable cycle: one period of the motion, at most MAX_CYCLE seconds."""
    seconds = min(dataset.recording.run.period or MAX_CYCLE, MAX_CYCLE)
    first = int(np.argmax(np.isfinite(dataset.torque).any(axis=1)))
    return slice(first, first + int(seconds * dataset.rate) + 1)


def build(recording: Recording, mechanism: Mechanism, method: str, cutoff: float | None) -> Dataset:
    """Preprocess `recording` by `method` and compute its regressor.

    Only the repeated motion is used, if the recording has one. Approach and stop serve as run-in of the filters.

    cutoff: [Hz]; None: chosen by the method.

    Raises:
        BadInput: the recording contains no usable data, or the method does not accept the cut-off.
    """
    samples = sample(recording)
    prepare = preprocessing.load(method)
    try:
        return assemble(recording, samples, prepare(samples, cutoff), mechanism)
    except BadInput as error:  # for example angles at which the mechanism cannot be assembled
        raise BadInput(f"{recording.path.name}: {error}") from None


def assemble(recording: Recording, samples: Samples, preprocessed: Preprocessed, mechanism: Mechanism) -> Dataset:
    """Assemble the rows of `recording` from its `preprocessed` samples and the regressor of `mechanism`.

    Raises:
        BadInput: too few rows, or angles at which the mechanism cannot be assembled.
    """
    regressor = _condition(preprocessed, mechanism.regressor, mechanism.pointwise)
    keep = slice(None, None, preprocessed.decimation)
    instants = preprocessed.instants[keep]
    usable = np.isfinite(preprocessed.torque) & np.isfinite(regressor).all(axis=2) & samples.selected[instants, None]
    _check_row_count(recording, int(usable.sum(axis=0).min()), MIN_ROWS_PER_PARAMETER * regressor.shape[2])
    return Dataset(
        recording=recording,
        time=instants / samples.rate,
        motion=_select(
            preprocessed.motion, np.arange(len(preprocessed.instants))[keep]
        ),  # a slice would keep the full array alive
        regressor=regressor,
        torque=np.where(usable, preprocessed.torque, np.nan),
        nominal=_nominal(preprocessed, mechanism),
        volt_sensitivity=preprocessed.sensitivity,
        repeat=samples.repeat[instants],
        phase=samples.phase[instants],
        rate=preprocessed.rate,
        bandwidth=preprocessed.bandwidth,
        cutoff=preprocessed.cutoff,
    )


def build_all(
    recordings: Sequence[Recording], mechanism: Mechanism, method: str, cutoff: float | None
) -> tuple[Dataset, ...]:
    """Build the data sets of several recordings with a common bandwidth: the lowest that any of them requires.

    Raises:
        BadInput: as `build`.
    """
    datasets = tuple(build(recording, mechanism, method, cutoff) for recording in recordings)
    lowest = min(
        (dataset.cutoff for dataset in datasets if dataset.cutoff), key=lambda choice: choice.hz, default=None
    )
    if lowest is None:
        return datasets
    return tuple(
        dataset
        if dataset.bandwidth == lowest.hz
        else replace(build(dataset.recording, mechanism, method, lowest.hz), cutoff=lowest)
        for dataset in datasets
    )


def _condition(preprocessed: Preprocessed, columns: Callable[[Motion], Floats], pointwise: bool) -> Floats:
    """Compute `columns` of the motion and condition them: (m, ...).

    Columns of a long recording at full rate do not fit into memory. If they depend only on the motion at the same
    instant (`pointwise`), they are computed in blocks, each padded by the half-width of the filter.
    """
    n, step, half_width = len(preprocessed.motion.position), preprocessed.decimation, preprocessed.half_width
    if not pointwise or half_width is None:
        return preprocessed.condition(columns(preprocessed.motion))
    before = -(-half_width // step)
    result: Floats | None = None  # concatenating the blocks would take twice the memory
    for first in range(0, n, BLOCK * step):
        start = max(0, first - before * step)
        motion = _select(preprocessed.motion, slice(start, first + BLOCK * step + half_width))
        conditioned = preprocessed.condition(columns(motion))
        offset, row = (first - start) // step, first // step
        if result is None:
            result = np.empty((-(-n // step), *conditioned.shape[1:]))
        result[row : row + BLOCK] = conditioned[offset : offset + BLOCK]
    assert result is not None  # there are samples
    return result


def _nominal(preprocessed: Preprocessed, mechanism: Mechanism) -> Floats | None:
    first = _select(preprocessed.motion, slice(1))
    if mechanism.nominal_torque(first) is None:
        return None
    return _condition(
        preprocessed, lambda motion: cast(Floats, mechanism.nominal_torque(motion)), mechanism.pointwise
    )


def _select(motion: Motion, index: slice | Ints) -> Motion:
    return Motion(**{field.name: getattr(motion, field.name)[index] for field in fields(Motion)})


def _check_row_count(recording: Recording, usable: int, expected: int) -> None:
    if usable < expected:
        raise BadInput(
            f"at least {expected} usable samples per joint expected after preprocessing, "
            f"{usable} of {len(recording.time)} recorded ones found; record longer or with fewer gaps"
        )
