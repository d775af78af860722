"""Resample the measured signals of a recording to a uniform grid of instants; gaps stay gaps."""

from dataclasses import dataclass
from functools import partial

import numpy as np

from ident.basics import filters
from ident.dynamics.torque_map import torque_from_voltage, torque_per_volt
from recordings.data_problems import signals
from recordings.data_problems.signals import LEAST_SIGNAL, MIN_TRAVEL
from recordings.errors import BadInput
from recordings.interpolation import interpolate_columns
from recordings.plausible import LARGEST, first_implausible
from recordings.recording import Bools, Floats, Ints, Recording
from recordings.schemas import POSITION_DELAY, VOLTAGE_DELAY

MAX_LATENESS = 0.1
"""Maximum distance of a sample from its SYNC on a uniform grid, in sample periods."""
MIN_RATE = 5.0
"""Minimum sampling rate [Hz]. In slower recordings, time is usually in another unit."""
MAX_STEP = 2.0
"""Samples further apart than this, in sample periods, are separated by a gap."""
MAX_DELAYED_STEP = 1.6
"""The same limit for a uniform grid whose values are measured with a delay."""
REST_SHARE = 0.01
"""A motion begins when a joint has moved by this share of its travel."""


@dataclass(frozen=True, eq=False)
class Samples:
    """n instants of dof joints. NaN marks a gap."""

    rate: float
    """Instants per second [Hz]."""
    window: float
    """Time over which the torque of an instant is averaged [s]."""
    position: Floats
    """(n, dof) [rad or m]."""
    drive: Floats
    """(n, dof) measured signal of the drives: voltage [V], or effort [N m or N]."""
    torque: Floats
    """(n, dof) [N m or N]."""
    slope: Floats
    """(n, dof) derivative of the torque with respect to `drive`."""
    repeat: Ints
    """(n,) index of the cycle; -1 outside of the repeated motion."""
    phase: Floats
    """(n,) time since the beginning of the cycle [s]; NaN outside of the repeated motion."""
    temperature: Floats
    """(n, dof) of the drives [degC]; NaN for joints where it was not measured."""
    selected: Bools
    """(n,) False during approach and stop, or at rest before and after a motion without marked cycles."""

    @property
    def known(self) -> Bools:
        """(n,) True where position and torque of all joints are known."""
        return np.logical_and.reduce(np.isfinite(np.hstack([self.position, self.torque])), axis=1)


def sample(recording: Recording, bridged: float = 0.0) -> Samples:
    """Resample `recording` to the grid of its SYNCs, or to the median step if its steps are not uniform.

    Non-uniform samples are interpolated by cubic splines, except across gaps of more than `bridged` [s].

    Raises:
        BadInput: the recording is not usable: a joint at rest, a constant drive signal, values that no joint has,
            decreasing time, less than MIN_RATE samples per second, or a run that was interrupted before its motion.
    """
    _check_complete(recording)
    drive, is_torque = drive_signal(recording), holds_torque(recording)
    _check_plausible(recording, "position", recording.position)
    _check_plausible(recording, "temperature", recording.temperature)
    _check_plausible(recording, "effort" if is_torque else "voltage", drive)
    _check_motion_and_drive(recording, drive)
    _check_increasing_time(recording)
    rate, index, uniform = grid(recording)
    _check_rate(recording, rate)
    longest = max(bridged, (MAX_DELAYED_STEP if uniform else MAX_STEP) / rate)
    on_grid = partial(_on_grid, recording, rate, index, longest, exact=uniform and not bridged)
    position = on_grid(recording.position, _delay(recording, POSITION_DELAY))
    torque = drive if is_torque else torque_from_voltage(drive, recording.rig.torque)
    _check_plausible(recording, "effort", torque)
    slope = np.ones_like(drive) if is_torque else torque_per_volt(drive, recording.rig.torque)
    delay = _median_delay(_delay(recording, VOLTAGE_DELAY))
    age = (recording.run.torque_age or 0.0) * rate
    # The torque is computed before interpolation, since its map is nonlinear and voltages ripple.
    drive, torque, slope = (_ahead(on_grid(x, delay), age) for x in (drive, torque, slope))
    repeat, phase = _cycles(recording, index, rate)
    instants = np.arange(len(position)) / rate
    return Samples(
        rate=rate,
        window=min(recording.run.torque_window or 1 / rate, 1 / rate),
        position=position,
        drive=drive,
        torque=torque,
        slope=slope,
        repeat=repeat,
        phase=phase,
        temperature=interpolate_columns(instants, recording.time, recording.temperature),
        selected=repeat >= 0 if (repeat >= 0).any() else _in_motion(position),
    )


def holds_torque(recording: Recording) -> bool:
    """Whether the recording contains measured effort and no voltage."""
    return signals.drive_signal(recording)[0] == "effort"


def is_relative(recording: Recording) -> bool:
    """Whether parameters fitted to `recording` are known only up to one common factor: its gains are assumed."""
    return recording.rig.torque.gain_source == "assumed" and not holds_torque(recording)


def drive_signal(recording: Recording) -> Floats:
    """(n, dof) measured signal of the drives: voltage [V], or effort [N m or N]."""
    return signals.drive_signal(recording)[1]


def _check_complete(recording: Recording) -> None:
    if not recording.complete and not (recording.repeat >= 0).any():
        raise BadInput(
            f"{recording.path.name}: a repeated motion expected, but the run was interrupted before it; record again"
        )


def _check_plausible(recording: Recording, quantity: str, values: Floats) -> None:
    if wrong := first_implausible(values, quantity):
        raise BadInput(
            f"{recording.path.name}: {quantity} within ±{LARGEST[quantity]:g} (SI units) expected, "
            f"{values[wrong]:g} of joint {wrong[1] + 1} at {recording.time[wrong[0]]:g} s found; check the drive, or "
            "the column that was imported and its unit"
        )


def _check_motion_and_drive(recording: Recording, drive: Floats) -> None:
    name, rig = recording.path.name, recording.rig
    # The approach does not count as motion where cycles are marked.
    motion = recording.repeat >= 0 if (recording.repeat >= 0).any() else slice(None)
    kind, units = ("effort", rig.effort_units) if holds_torque(recording) else ("voltage", ("V",) * rig.dof)
    for joint, (position, signal) in enumerate(
        zip(recording.position[motion].T, drive[motion].T, strict=True), start=1
    ):
        position, signal = position[np.isfinite(position)], signal[np.isfinite(signal)]
        if not len(position) or np.ptp(position) < MIN_TRAVEL:
            raise BadInput(f"{name}: joint {joint} should move, but its position is constant; record a motion")
        if not len(signal) or np.ptp(signal) < LEAST_SIGNAL:
            value = f"{signal[0]:g} {units[joint - 1]} throughout" if len(signal) else "never received"
            raise BadInput(
                f"{name}: {'an' if kind == 'effort' else 'a'} {kind} that drives the motion expected, but that of "
                f"joint {joint} is {value}; check the {kind} object in the rig file, or the column that was imported"
            )


def _check_increasing_time(recording: Recording) -> None:
    step = np.diff(recording.time)
    if (step <= 0).any():
        at = int(np.argmax(step <= 0))
        raise BadInput(
            f"{recording.path.name}: time that increases from sample to sample expected, {recording.time[at]:g} s is "
            f"followed by {recording.time[at + 1]:g} s; check the time stamps"
        )


def _check_rate(recording: Recording, rate: float) -> None:
    if rate < MIN_RATE:
        raise BadInput(
            f"{recording.path.name}: at least {MIN_RATE:g} samples per second expected, {rate:.3g} found in "
            f"{recording.time[-1]:.0f} s; check that time is in seconds, and not in milliseconds"
        )


def grid(recording: Recording) -> tuple[float, Ints, bool]:
    """Rate of the grid [Hz], the nearest instant of each sample, and whether the samples lie on the grid."""
    rate = recording.run.rate
    index = np.rint(recording.time * rate).astype(np.int64)
    if _is_uniform(recording, index):
        return rate, index, True
    rate = float(1 / np.median(np.diff(recording.time)))
    last = int(recording.time[-1] * rate * (1 + 1e-12))
    return rate, np.minimum(np.rint(recording.time * rate).astype(np.int64), last), False


def _delay(recording: Recording, name: str) -> Floats | None:
    """(n, dof) delay of each measured value after its SYNC [s]; None: no delay.

    Drives on a shared line are read one after the other.
    """
    delays = recording.numbered(name)
    return None if np.isnan(delays).all(axis=0).any() else delays


def _median_delay(delay: Floats | None) -> Floats | None:
    """Replace the delays of each joint by their median.

    Voltage ripple and delays both vary with the SYNC cycle. Interpolation with the individual delays would produce
    slow errors, which a low-pass does not remove.
    """
    return None if delay is None else np.broadcast_to(np.nanmedian(delay, axis=0), delay.shape)


def _ahead(x: Floats, steps: float) -> Floats:
    """Interpolate `x` (n, dof) so many `steps` after each instant of the grid: cubic polynomials through 4 samples.

    The torque that drives report may be older than the position beside it: 0.2 ms of an inertia's torque look like a
    hundredth of the viscous friction. For an hour's recording, the splines of uneven delays would take seconds.
    """
    if not steps:
        return x
    offsets = int(np.floor(steps)) + np.arange(-1, 3)
    reach = int(np.abs(offsets).max())
    taps = np.zeros(2 * reach + 1)
    taps[reach - offsets] = np.linalg.solve(np.vander(offsets, increasing=True).T, steps ** np.arange(4))
    return filters.convolve(x, taps)


def _on_grid(
    recording: Recording, rate: float, index: Ints, longest: float, x: Floats, delay: Floats | None, *, exact: bool
) -> Floats:
    """Resample `x` (n, dof) to the grid; `exact`: its samples are on the grid, unless they have a delay."""
    if exact and delay is None:
        return _fill_gaps(x, index)
    time = np.broadcast_to(recording.time[:, None], x.shape)
    if delay is not None:
        time = time + delay
    instants = np.arange(index[-1] + 1) / rate
    columns = [_interpolate(t, signal, instants, longest) for t, signal in zip(time.T, x.T, strict=True)]
    return np.stack(columns, axis=1)


def _is_uniform(recording: Recording, index: Ints) -> bool:
    """Whether every sample is close to its SYNC `index` (n,), with at most one sample per SYNC."""
    off = np.abs(recording.time * recording.run.rate - index)
    return bool((np.diff(index) >= 1).all() and off.max() <= MAX_LATENESS)


def _fill_gaps(x: Floats, index: Ints) -> Floats:
    """Place `x` (n, ...) at the instants `index`; NaN at instants without a sample (an unanswered SYNC)."""
    if len(index) == index[-1] + 1:
        return x  # no copy: the arrays are large and are not modified
    full: Floats = np.full((index[-1] + 1, *x.shape[1:]), np.nan)
    full[index] = x
    return full


def _interpolate(time: Floats, signal: Floats, grid: Floats, longest: float) -> Floats:
    """Interpolate `signal` (n,) at the instants `grid` [s] by a cubic spline through the known samples; NaN in gaps.

    Two samples further apart than `longest` [s] are separated by a gap.
    """
    from scipy.interpolate import CubicSpline

    known = np.isfinite(signal) & np.isfinite(time)
    instants = time[known]
    after = np.clip(np.searchsorted(instants, grid), 1, len(instants) - 1)
    gap = instants[after] - instants[after - 1] > longest * (1 + 1e-6)
    outside = (grid < instants[0]) | (grid > instants[-1])
    values = CubicSpline(instants, signal[known])(grid)
    return np.where(gap | outside, np.nan, values)


def _cycles(recording: Recording, index: Ints, rate: float) -> tuple[Ints, Floats]:
    """Cycle (n,) of every instant, -1 outside of cycles, and its phase (n,) [s], NaN outside of cycles.

    If the host misses SYNCs, the motion pauses and resumes; if samples are lost otherwise, it continues. In the first
    case the number of samples equals the period, in the second case the number of SYNCs does.
    """
    repeat: Ints = np.full(index[-1] + 1, -1, np.int64)
    phase: Floats = np.full(len(repeat), np.nan)
    period = round(recording.run.period * rate)
    first = end = 0
    for number in np.unique(recording.repeat[recording.repeat >= 0]):
        cycle_index = index[recording.repeat == number]
        paused = len(cycle_index) == period
        # A cycle that begins in a gap began one period after the previous one.
        first = int(cycle_index[0] if paused or end == 0 else min(max(end, first + period), cycle_index[0]))
        end = int(cycle_index[-1]) + 1
        instants = np.arange(first, end)
        repeat[instants] = number
        phase[instants] = (np.searchsorted(cycle_index, instants) if paused else instants - first) / rate
    return repeat, phase


def _in_motion(position: Floats) -> Bools:
    """(n,) True from the first departure of a joint from its start until the last arrival of a joint at its end."""
    threshold = REST_SHARE * (np.nanmax(position, axis=0) - np.nanmin(position, axis=0))
    known = np.isfinite(position)
    first = position[known.argmax(axis=0), np.arange(position.shape[1])]
    last = position[len(position) - 1 - known[::-1].argmax(axis=0), np.arange(position.shape[1])]
    departed = (np.abs(position - first) > threshold).any(axis=1)
    not_arrived = (np.abs(position - last) > threshold).any(axis=1)
    moving = np.zeros(len(position), bool)
    moving[int(departed.argmax()) : len(position) - int(not_arrived[::-1].argmax())] = True
    return moving
