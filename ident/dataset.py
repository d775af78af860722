"""One recording as rows for an estimator: the usable samples of its repeated motion, with their regressor."""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from ident import preprocess
from ident.mechanisms import Mechanism
from ident.motion import Motion
from ident.torque_map import torque_from_voltage, torque_per_volt
from recordings.errors import BadInput
from recordings.recording import Floats, Ints, Recording

LEAST_TRAVEL = 1e-3
"""A joint that moves less than this is held still [rad]."""
LEAST_ROWS = 10
"""Usable samples per parameter below which nothing is fitted."""


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

    def rows(self) -> tuple[Floats, Floats]:
        """Regressor (r, k) and torque (r,) of the usable joint samples, one joint after the other."""
        usable = np.isfinite(self.torque).T
        return self.regressor.swapaxes(0, 1)[usable], self.torque.T[usable]


def build(recording: Recording, mechanism: Mechanism, method: str, cutoff: float | None) -> Dataset:
    """Preprocess `recording` by `method`, at `cutoff` [Hz] or the method's own, and compute its regressor.

    Only the repeated motion is used, if the recording has one; approach and stop serve the filters as run-in.

    Raises:
        BadInput: the recording holds nothing that could be fitted, or the method refuses the cut-off.
    """
    _refuse_useless(recording)
    rate = recording.run.rate
    sync = _sync_index(recording)
    voltage = _on_every_sync(recording.voltage, sync)
    torque = torque_from_voltage(voltage, recording.rig.torque)
    prepared = preprocess.load(method)(_on_every_sync(recording.position, sync), torque, rate, cutoff)
    keep = slice(None, None, prepared.step)
    try:
        regressor = prepared.condition(mechanism.regressor(prepared.motion))
    except BadInput as error:  # say, angles at which the mechanism does not close
        raise BadInput(f"{recording.path.name}: {error}") from None
    nominal = mechanism.nominal_torque(prepared.motion)
    usable = prepared.mask & np.isfinite(regressor).all(axis=2)
    repeat, phase = _repetitions(recording, sync)
    if (repeat >= 0).any():
        usable &= repeat[keep, None] >= 0
    _refuse_few(recording, int(usable.sum(axis=0).min()), LEAST_ROWS * regressor.shape[2])
    return Dataset(
        recording=recording,
        time=np.arange(len(torque))[keep] / rate,
        motion=Motion(**{field.name: getattr(prepared.motion, field.name)[keep] for field in fields(Motion)}),
        regressor=regressor,
        torque=np.where(usable, prepared.torque, np.nan),
        nominal=None if nominal is None else prepared.condition(nominal),
        volt_sensitivity=prepared.sensitivity(torque_per_volt(voltage, recording.rig.torque)),
        repeat=repeat[keep],
        phase=phase[keep],
        rate=prepared.rate,
        bandwidth=prepared.bandwidth,
    )


def _refuse_useless(recording: Recording) -> None:
    name = recording.path.name
    if not recording.complete and not (recording.repeat >= 0).any():
        raise BadInput(f"{name}: a repeated motion expected, but the run was interrupted before it; record it again")
    for joint, (position, voltage) in enumerate(zip(recording.position.T, recording.voltage.T, strict=True), start=1):
        position, voltage = position[np.isfinite(position)], voltage[np.isfinite(voltage)]
        if not len(position) or np.ptp(position) < LEAST_TRAVEL:
            raise BadInput(f"{name}: joint {joint} should move, but its position is constant; record a motion")
        if not len(voltage) or np.ptp(voltage) == 0:
            found = f"{voltage[0]:g} V throughout" if len(voltage) else "never received"
            raise BadInput(
                f"{name}: a voltage that drives the motion expected, but that of joint {joint} is {found}; check the "
                "voltage object in the rig file"
            )


def _sync_index(recording: Recording) -> Ints:
    """(n,) number of the SYNC that each sample belongs to; one that nobody answered to has no sample."""
    index = np.rint(recording.time * recording.run.rate).astype(np.int64)
    step = np.diff(recording.time)
    off = np.abs(recording.time * recording.run.rate - index)
    if (np.diff(index) < 1).any() or off.max() > 0.1:
        raise BadInput(
            f"{recording.path.name}: a sample every {1e3 / recording.run.rate:g} ms expected, steps from "
            f"{1e3 * step.min():g} to {1e3 * step.max():g} ms found; check the time stamps"
        )
    return index


def _repetitions(recording: Recording, sync: Ints) -> tuple[Ints, Floats]:
    """Of every SYNC: its repetition, -1 where none, and how far into it the motion is [s], NaN where none.

    The motion waits while the host misses SYNCs (it resumes where it stood); where samples were lost otherwise, it
    went on. Which of the two it was, shows in what fills the period: the samples, or the SYNCs.
    """
    repeat: Ints = np.full(sync[-1] + 1, -1, np.int64)
    phase: Floats = np.full(len(repeat), np.nan)
    period = round(recording.run.period * recording.run.rate)
    first = end = 0
    for number in np.unique(recording.repeat[recording.repeat >= 0]):
        own = sync[recording.repeat == number]
        waited = len(own) == period
        # A repetition that begins in a hole began a period after the last one did.
        first = int(own[0] if waited or end == 0 else min(max(end, first + period), own[0]))
        end = int(own[-1]) + 1
        every = np.arange(first, end)
        repeat[every] = number
        phase[every] = (np.searchsorted(own, every) if waited else every - first) / recording.run.rate
    return repeat, phase


def _on_every_sync(x: Floats | NDArray[np.bool_], sync: Ints) -> Floats:
    """`x` (n, ...) on the full grid of SYNCs; NaN where there is no sample."""
    full: Floats = np.full((sync[-1] + 1, *x.shape[1:]), np.nan)
    full[sync] = x
    return full


def _refuse_few(recording: Recording, found: int, expected: int) -> None:
    if found < expected:
        raise BadInput(
            f"{recording.path.name}: at least {expected} usable samples per joint expected after preprocessing, "
            f"{found} of {len(recording.time)} recorded ones found; record longer or with fewer gaps"
        )
