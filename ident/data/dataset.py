"""One recording as rows for an estimator: the usable samples of its repeated motion, with their regressor."""

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
"""Conditioned samples that are made at a time."""
MIN_ROWS_PER_PARAMETER = 10
"""Usable samples per parameter below which nothing is fitted."""
MAX_CYCLE = 4.0
"""Seconds that are drawn at most where curves must be told apart."""


@dataclass(frozen=True, eq=False)
class Dataset:
    """m samples of dof joints, after preprocessing. The torque is NaN where a sample is not to be used."""

    recording: Recording
    time: Floats
    """(m,) from the recording's first SYNC [s]."""
    motion: Motion
    """(m, dof), for looking at the residual; the regressor was made from the motion at full rate."""
    regressor: Floats
    """(m, dof, k)."""
    torque: Floats
    """(m, dof) measured torque [N m]."""
    nominal: Floats | None
    """(m, dof) torque of the manufacturer's model [N m], where there is one."""
    volt_sensitivity: Floats
    """(m, dof) torque noise per noise in the measured voltage, both after preprocessing [N m/V]."""
    repeat: Ints
    """(m,) repetition of the motion; -1 outside of all."""
    phase: Floats
    """(m,) time since the repetition began [s]; NaN outside of all."""
    rate: float
    """Samples per second [Hz]."""
    bandwidth: float
    """[Hz]."""
    cutoff: Cutoff | None
    """How the bandwidth was chosen, where there is a choice."""
    offset: Floats | None = None
    """(m, dof) torque that the model says is there whatever its parameters [N m]; None: nothing."""

    def rows(self) -> tuple[Floats, Floats]:
        """Regressor (r, k) and torque (r,) to fit, of the usable joint samples, one joint after the other."""
        usable = np.isfinite(self.torque).T
        torque = self.torque if self.offset is None else self.torque - self.offset
        return self.regressor.swapaxes(0, 1)[usable], torque.T[usable]

    def predicted_torque(self, parameters: Floats) -> Floats:
        """Torque (m, dof) [N m] that the model computes with `parameters` (k,)."""
        computed: Floats = self.regressor @ parameters
        return computed if self.offset is None else computed + self.offset


def first_cycle(dataset: Dataset) -> slice:
    """The first usable samples, one period of the motion or LONGEST, whichever is shorter."""
    seconds = min(dataset.recording.run.period or MAX_CYCLE, MAX_CYCLE)
    first = int(np.argmax(np.isfinite(dataset.torque).any(axis=1)))
    return slice(first, first + int(seconds * dataset.rate) + 1)


def build(recording: Recording, mechanism: Mechanism, method: str, cutoff: float | None) -> Dataset:
    """Preprocess `recording` by `method`, at `cutoff` [Hz] or the method's own, and compute its regressor.

    Only the repeated motion is used, if the recording has one; approach and stop serve the filters as run-in.

    Raises:
        BadInput: the recording holds nothing that could be fitted, or the method refuses the cut-off.
    """
    samples = sample(recording)
    prepare = preprocessing.load(method)
    try:
        return assemble(recording, samples, prepare(samples, cutoff), mechanism)
    except BadInput as error:  # say, angles at which the mechanism does not close
        raise BadInput(f"{recording.path.name}: {error}") from None


def assemble(recording: Recording, samples: Samples, prepared: Preprocessed, mechanism: Mechanism) -> Dataset:
    """The rows of `recording`, whose `samples` have been `prepared`, with the regressor of `mechanism`.

    Raises:
        BadInput: too few rows, or angles at which the mechanism does not close.
    """
    regressor = _conditioned(prepared, mechanism.regressor, mechanism.pointwise)
    keep = slice(None, None, prepared.decimation)
    instants = prepared.instants[keep]
    usable = np.isfinite(prepared.torque) & np.isfinite(regressor).all(axis=2) & samples.selected[instants, None]
    _refuse_few(recording, int(usable.sum(axis=0).min()), MIN_ROWS_PER_PARAMETER * regressor.shape[2])
    return Dataset(
        recording=recording,
        time=instants / samples.rate,
        motion=_part(prepared.motion, np.arange(len(prepared.instants))[keep]),  # a slice would keep all of it
        regressor=regressor,
        torque=np.where(usable, prepared.torque, np.nan),
        nominal=_nominal(prepared, mechanism),
        volt_sensitivity=prepared.sensitivity,
        repeat=samples.repeat[instants],
        phase=samples.phase[instants],
        rate=prepared.rate,
        bandwidth=prepared.bandwidth,
        cutoff=prepared.cutoff,
    )


def build_all(
    recordings: Sequence[Recording], mechanism: Mechanism, method: str, cutoff: float | None
) -> tuple[Dataset, ...]:
    """The data sets of several recordings, all of one bandwidth: the lowest that any of them asks for.

    Raises:
        BadInput: as `build`.
    """
    datasets = tuple(build(recording, mechanism, method, cutoff) for recording in recordings)
    lowest = min((dataset.cutoff for dataset in datasets if dataset.cutoff), key=lambda found: found.hz, default=None)
    if lowest is None:
        return datasets
    return tuple(
        dataset
        if dataset.bandwidth == lowest.hz
        else replace(build(dataset.recording, mechanism, method, lowest.hz), cutoff=lowest)
        for dataset in datasets
    )


def _conditioned(prepared: Preprocessed, columns: Callable[[Motion], Floats], pointwise: bool) -> Floats:
    """What `columns` makes of the motion, conditioned: (m, ...).

    Columns of a long recording at full rate do not fit into memory. Where an instant's columns depend on nothing else
    (`pointwise`), they are made and conditioned in blocks, each with the surroundings that the filter looks at.
    """
    n, step, reach = len(prepared.motion.position), prepared.decimation, prepared.half_width
    if not pointwise or reach is None:
        return prepared.condition(columns(prepared.motion))
    before = -(-reach // step)
    whole: Floats | None = None  # blocks that were joined in the end would take twice the memory
    for first in range(0, n, BLOCK * step):
        start = max(0, first - before * step)
        part = _part(prepared.motion, slice(start, first + BLOCK * step + reach))
        conditioned = prepared.condition(columns(part))
        own, place = (first - start) // step, first // step
        if whole is None:
            whole = np.empty((-(-n // step), *conditioned.shape[1:]))
        whole[place : place + BLOCK] = conditioned[own : own + BLOCK]
    assert whole is not None  # there are samples
    return whole


def _nominal(prepared: Preprocessed, mechanism: Mechanism) -> Floats | None:
    first = _part(prepared.motion, slice(1))
    if mechanism.nominal_torque(first) is None:
        return None
    return _conditioned(prepared, lambda motion: cast(Floats, mechanism.nominal_torque(motion)), mechanism.pointwise)


def _part(motion: Motion, which: slice | Ints) -> Motion:
    return Motion(**{field.name: getattr(motion, field.name)[which] for field in fields(Motion)})


def _refuse_few(recording: Recording, found: int, expected: int) -> None:
    if found < expected:
        raise BadInput(
            f"at least {expected} usable samples per joint expected after preprocessing, "
            f"{found} of {len(recording.time)} recorded ones found; record longer or with fewer gaps"
        )
