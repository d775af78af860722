"""The measured signals of a recording on an even grid of instants, with its gaps, as every later stage needs them."""

from dataclasses import dataclass

import numpy as np

from ident.dynamics.torque_map import torque_from_voltage, torque_per_volt
from recordings.errors import BadInput
from recordings.recording import Bools, Floats, Ints, Recording
from recordings.schemas import POSITION_DELAY, VOLTAGE_DELAY

MIN_TRAVEL = 1e-3
"""A joint that moves less than this is held still [rad or m]."""
MAX_LATENESS = 0.1
"""A sample that is further than this from its SYNC, in sample periods, is not of an even grid."""
MIN_RATE = 5.0
"""Slower recordings show no dynamics of a drive; mostly their time is in another unit [Hz]."""
MAX_STEP = 2.0
"""Samples further apart than this, in sample periods, have a gap between them."""
MAX_DELAYED_STEP = 1.6
"""Likewise where one is due in every period, but measured somewhat later than its instant."""
REST_SHARE = 0.01
"""A motion begins when a joint has left its place by this share of its travel."""


@dataclass(frozen=True, eq=False)
class Samples:
    """n instants of dof joints. NaN is a gap."""

    rate: float
    """Instants per second [Hz]."""
    position: Floats
    """(n, dof) [rad or m]."""
    drive: Floats
    """(n, dof) what was measured of the drives: voltage [V], or else the effort itself."""
    torque: Floats
    """(n, dof) [N m or N]."""
    slope: Floats
    """(n, dof) derivative of the torque by `drive`."""
    repeat: Ints
    """(n,) repetition of the motion; -1 outside of all."""
    phase: Floats
    """(n,) time since the repetition began [s]; NaN outside of all."""
    selected: Bools
    """(n,) False while approaching and stopping, or at rest before and after a motion that is not marked."""


def sample(recording: Recording) -> Samples:
    """The signals of `recording`, on the grid of its SYNCs, or on a grid of the median step if its steps are uneven.

    Uneven samples are joined by cubic splines, but nothing is invented in a gap.

    Raises:
        BadInput: the recording holds nothing that could be fitted: a joint at rest, a drive that gives nothing, time
            that runs backwards, less than LEAST_RATE samples per second, a run that was interrupted before its
            motion.
    """
    _refuse_incomplete(recording)
    drive, is_torque = drive_signal(recording), holds_torque(recording)
    _refuse_useless(recording, drive)
    _refuse_backwards(recording)
    rate, index, even = _grid(recording)
    _refuse_slow(recording, rate)
    position = _on_grid(recording, recording.position, _delay(recording, POSITION_DELAY), rate, index, even=even)
    torque = drive if is_torque else torque_from_voltage(drive, recording.rig.torque)
    slope = np.ones_like(drive) if is_torque else torque_per_volt(drive, recording.rig.torque)
    late = _steady(_delay(recording, VOLTAGE_DELAY))
    # The torque follows from every voltage as it was measured: its map is not linear, and voltages ripple.
    drive, torque, slope = (_on_grid(recording, x, late, rate, index, even=even) for x in (drive, torque, slope))
    repeat, phase = _repetitions(recording, index, rate)
    return Samples(
        rate=rate,
        position=position,
        drive=drive,
        torque=torque,
        slope=slope,
        repeat=repeat,
        phase=phase,
        selected=repeat >= 0 if (repeat >= 0).any() else _in_motion(position),
    )


def holds_torque(recording: Recording) -> bool:
    """True where the effort itself was measured, and no voltage."""
    return recording.effort is not None and not np.isfinite(recording.voltage).any()


def drive_signal(recording: Recording) -> Floats:
    """(n, dof) what was measured of the drives: voltage [V], or else the effort itself [N m or N]."""
    effort = recording.effort if holds_torque(recording) else None
    return recording.voltage if effort is None else effort


def _refuse_incomplete(recording: Recording) -> None:
    if not recording.complete and not (recording.repeat >= 0).any():
        raise BadInput(
            f"{recording.path.name}: a repeated motion expected, but the run was interrupted before it; record again"
        )


def _refuse_useless(recording: Recording, drive: Floats) -> None:
    name, rig = recording.path.name, recording.rig
    # What moves on the way to the start does not count where the motion itself is known.
    motion = recording.repeat >= 0 if (recording.repeat >= 0).any() else slice(None)
    kind, units = ("effort", rig.effort_units) if holds_torque(recording) else ("voltage", ("V",) * rig.dof)
    for joint, (position, signal) in enumerate(
        zip(recording.position[motion].T, drive[motion].T, strict=True), start=1
    ):
        position, signal = position[np.isfinite(position)], signal[np.isfinite(signal)]
        if not len(position) or np.ptp(position) < MIN_TRAVEL:
            raise BadInput(f"{name}: joint {joint} should move, but its position is constant; record a motion")
        if not len(signal) or np.ptp(signal) == 0:
            found = f"{signal[0]:g} {units[joint - 1]} throughout" if len(signal) else "never received"
            raise BadInput(
                f"{name}: {'an' if kind == 'effort' else 'a'} {kind} that drives the motion expected, but that of "
                f"joint {joint} is {found}; check the {kind} object in the rig file, or the column that was imported"
            )


def _refuse_backwards(recording: Recording) -> None:
    step = np.diff(recording.time)
    if (step <= 0).any():
        at = int(np.argmax(step <= 0))
        raise BadInput(
            f"{recording.path.name}: time that increases from sample to sample expected, {recording.time[at]:g} s is "
            f"followed by {recording.time[at + 1]:g} s; check the time stamps"
        )


def _refuse_slow(recording: Recording, rate: float) -> None:
    if rate < MIN_RATE:
        raise BadInput(
            f"{recording.path.name}: at least {MIN_RATE:g} samples per second expected, {rate:.3g} found in "
            f"{recording.time[-1]:.0f} s; check that time is in seconds, and not in milliseconds"
        )


def _grid(recording: Recording) -> tuple[float, Ints, bool]:
    """Instants per second [Hz], the instant next to each sample, and whether the samples are there in truth."""
    rate = recording.run.rate
    index = np.rint(recording.time * rate).astype(np.int64)
    if _is_even(recording, index):
        return rate, index, True
    rate = float(1 / np.median(np.diff(recording.time)))
    last = int(recording.time[-1] * rate * (1 + 1e-12))
    return rate, np.minimum(np.rint(recording.time * rate).astype(np.int64), last), False


def _delay(recording: Recording, name: str) -> Floats | None:
    """(n, dof) how much later than its SYNC each value was measured [s]; None: with it.

    Drives that share a line are read one after the other.
    """
    columns = [recording.extra.get(f"{name}_{i}") for i in range(1, recording.rig.dof + 1)]
    found = [column for column in columns if column is not None]
    return np.stack(found, axis=1) if found and len(found) == len(columns) else None


def _steady(delay: Floats | None) -> Floats | None:
    """The usual delay of each joint for all its values.

    Voltages ripple with the targets from cycle to cycle, and so do their delays, with the drive whose status is read
    too. Taken as they are, the two together would give slow errors, which no low-pass takes out again.
    """
    return None if delay is None else np.broadcast_to(np.nanmedian(delay, axis=0), delay.shape)


def _on_grid(
    recording: Recording, x: Floats, delay: Floats | None, rate: float, index: Ints, *, even: bool
) -> Floats:
    """`x` (n, dof) at every instant of the grid."""
    if even and delay is None:
        return _on_every_instant(x, index)
    time = np.broadcast_to(recording.time[:, None], x.shape)
    if delay is not None:
        time = time + delay
    instants = np.arange(index[-1] + 1) / rate
    longest = (MAX_DELAYED_STEP if even else MAX_STEP) / rate
    columns = [_interpolated(own, signal, instants, longest) for own, signal in zip(time.T, x.T, strict=True)]
    return np.stack(columns, axis=1)


def _is_even(recording: Recording, index: Ints) -> bool:
    """Whether every sample is on time for the SYNC `index` (n,), and no two for the same."""
    off = np.abs(recording.time * recording.run.rate - index)
    return bool((np.diff(index) >= 1).all() and off.max() <= MAX_LATENESS)


def _on_every_instant(x: Floats, index: Ints) -> Floats:
    """`x` (n, ...) at the instants `index`; NaN where there is no sample: a SYNC that nobody answered to."""
    if len(index) == index[-1] + 1:
        return x  # no copy: they are large, and nobody changes them
    full: Floats = np.full((index[-1] + 1, *x.shape[1:]), np.nan)
    full[index] = x
    return full


def _interpolated(time: Floats, signal: Floats, grid: Floats, longest: float) -> Floats:
    """`signal` (n,) at the instants `grid` [s], by a cubic spline through the known samples; NaN in gaps.

    Two samples further apart than `longest` [s] have a gap between them.
    """
    from scipy.interpolate import CubicSpline

    known = np.isfinite(signal) & np.isfinite(time)
    instants = time[known]
    after = np.clip(np.searchsorted(instants, grid), 1, len(instants) - 1)
    gap = instants[after] - instants[after - 1] > longest * (1 + 1e-6)
    outside = (grid < instants[0]) | (grid > instants[-1])
    values = CubicSpline(instants, signal[known])(grid)
    return np.where(gap | outside, np.nan, values)


def _repetitions(recording: Recording, index: Ints, rate: float) -> tuple[Ints, Floats]:
    """Of every instant: its repetition, -1 where none, and how far into it the motion is [s], NaN where none.

    The motion waits while the host misses SYNCs (it resumes where it stood); where samples were lost otherwise, it
    went on. Which of the two it was, shows in what fills the period: the samples, or the SYNCs.
    """
    repeat: Ints = np.full(index[-1] + 1, -1, np.int64)
    phase: Floats = np.full(len(repeat), np.nan)
    period = round(recording.run.period * rate)
    first = end = 0
    for number in np.unique(recording.repeat[recording.repeat >= 0]):
        own = index[recording.repeat == number]
        waited = len(own) == period
        # A repetition that begins in a hole began a period after the last one did.
        first = int(own[0] if waited or end == 0 else min(max(end, first + period), own[0]))
        end = int(own[-1]) + 1
        every = np.arange(first, end)
        repeat[every] = number
        phase[every] = (np.searchsorted(own, every) if waited else every - first) / rate
    return repeat, phase


def _in_motion(position: Floats) -> Bools:
    """(n,) True from where the first joint has left the place it began at, until the last is where it ends."""
    away = REST_SHARE * (np.nanmax(position, axis=0) - np.nanmin(position, axis=0))
    known = np.isfinite(position)
    first = position[known.argmax(axis=0), np.arange(position.shape[1])]
    last = position[len(position) - 1 - known[::-1].argmax(axis=0), np.arange(position.shape[1])]
    left = (np.abs(position - first) > away).any(axis=1)
    to_go = (np.abs(position - last) > away).any(axis=1)
    moving = np.zeros(len(position), bool)
    moving[int(left.argmax()) : len(position) - int(to_go[::-1].argmax())] = True
    return moving
