"""Sampling a motion for streaming: soft start, identical cycles, soft end."""

import hashlib
import json
from dataclasses import dataclass

import numpy as np

from recordings.errors import BadInput
from recordings.recording import Floats, Ints
from recordings.rig import Geometry, Rig
from trajectories import kinematics
from trajectories.motion import PlannedMotion

RAMP_SECONDS = 1.0
"""Duration of the soft start, and of the soft end [s]."""
DEFAULT_SECONDS = 20.0
"""Approximate duration of all repetitions where their number is not given [s]."""

MIN_RATE = 10.0
"""Lowest rate [Hz]."""
MIN_SAMPLES = 20
"""Smallest number of samples in one repetition."""
MAX_SAMPLES = 10_000_000
"""Largest number of samples in total: hours, and a gigabyte of memory."""


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A motion sampled at the cycle rate, at rest at both ends; arrays have one row per cycle (SYNC)."""

    name: str
    description: str
    digest: str
    """SHA-256 of everything that determines the samples: motion, geometry, rate and cycles."""
    rate: float
    """Samples per second [Hz]."""
    period: float
    """Duration of one repetition [s]; 0 where the motion does not repeat."""
    cycles: int
    """Number of repetitions."""
    platform: Floats
    """(n, 3) platform position [m]; NaN for a rig without platform."""
    joint_position: Floats
    """(n, dof) joint position [rad or m]."""
    joint_velocity: Floats
    """(n, dof) joint velocity [rad/s or m/s]."""
    joint_acceleration: Floats
    """(n, dof) joint acceleration [rad/s^2 or m/s^2]."""
    repeat: Ints
    """(n,) repetition of each sample, 0 to cycles - 1; -1 during soft start and end."""

    @property
    def time(self) -> Floats:
        """(n,) time since the first sample [s]."""
        return np.arange(len(self.repeat)) / self.rate


@dataclass(frozen=True)
class _Timing:
    """Phase time of lead-in, one repetition and lead-out, with its first two time derivatives."""

    phase: Floats
    speed: Floats
    acceleration: Floats
    ramp: int
    """Number of samples of the lead-in; the lead-out has one more, at rest."""
    samples: int
    """Number of samples of one repetition."""


def assemble(motion: PlannedMotion, rig: Rig, cycles: int | None = None, rate: float | None = None) -> Trajectory:
    """Sample `motion` for `rig`, `cycles` times (default: about 20 s) at `rate` [Hz] (default: the rig's).

    The phase speed of the motion is ramped from 0 to 1 before the first repetition and back to 0 after the last, so
    that all repetitions are identical, sample for sample. In a motion that does not repeat, the ramps are part of
    the motion. The duration is rounded to a whole number of samples.

    Raises:
        BadInput: rate or cycles are invalid for this motion.
        Unreachable: the robot cannot reach a position; the error names the first instant.
    """
    rate = rig.rate if rate is None else rate
    if cycles is None:
        cycles = max(1, round(DEFAULT_SECONDS / motion.duration)) if motion.periodic else 1
    _check_cycles_and_rate(motion, cycles, rate)
    timing = _timing(motion, rate)
    rows = np.r_[
        : timing.ramp,
        np.tile(np.arange(timing.ramp, timing.ramp + timing.samples), cycles),
        timing.ramp + timing.samples : len(timing.phase),
    ]
    try:
        states = _joint_states(motion, rig, timing)
    except kinematics.Unreachable as error:
        raise error.at(f"{motion.name}, t = {np.argmax(rows == error.row) / rate:.3f} s") from None
    platform, position, velocity, acceleration = (state[rows] for state in states)
    repeat = np.full(len(rows), -1)
    repeat[timing.ramp : timing.ramp + cycles * timing.samples] = np.repeat(np.arange(cycles), timing.samples)
    return Trajectory(
        name=motion.name,
        description=motion.description,
        digest=_digest(motion, rig.geometry, rate, cycles),
        rate=rate,
        period=timing.samples / rate if motion.periodic else 0.0,
        cycles=cycles,
        platform=platform,
        joint_position=position,
        joint_velocity=velocity,
        joint_acceleration=acceleration,
        repeat=repeat,
    )


def _check_cycles_and_rate(motion: PlannedMotion, cycles: int, rate: float) -> None:
    if cycles < 1:
        raise BadInput(f"{motion.name}: at least one cycle expected, {cycles} found")
    if cycles > 1 and not motion.periodic:
        raise BadInput(
            f"{motion.name} does not end where it begins, so it cannot repeat: 1 cycle expected, {cycles} found; "
            "close the path or leave out --cycles"
        )
    shortest = 2 * RAMP_SECONDS
    if not motion.periodic and motion.duration < shortest:
        raise BadInput(
            f"{motion.name}: a path of {shortest:g} s or more expected, {motion.duration:g} s found; slow it down"
        )
    samples = motion.duration * rate * cycles
    if samples > MAX_SAMPLES:
        raise BadInput(
            f"{motion.name}: at most {MAX_SAMPLES:,} samples in one recording expected, {samples:.3g} found; "
            "ask for fewer cycles or a lower rate"
        )
    if not (MIN_RATE <= rate < np.inf and motion.duration * rate >= MIN_SAMPLES):
        raise BadInput(
            f"{motion.name}: a rate of at least {max(MIN_RATE, MIN_SAMPLES / motion.duration):g} Hz expected, "
            f"{rate:g} Hz found; raise the rate"
        )


def _timing(motion: PlannedMotion, rate: float) -> _Timing:
    ramp = round(RAMP_SECONDS * rate)
    samples = round(motion.duration * rate) - (0 if motion.periodic else ramp)
    # Phase seconds per second: 1 except for rounding the duration to whole samples.
    speed = motion.duration * rate / (samples if motion.periodic else samples + ramp)
    u = np.arange(ramp + 1) / ramp
    # Smootherstep, its integral and derivative: the phase speed rises from 0 to 1 without a jump in jerk.
    ramp_speed = u**3 * (10 - 15 * u + 6 * u**2)
    ramp_phase = (u**4 * (2.5 - 3 * u + u**2)) * ramp / rate
    ramp_acceleration = 30 * u**2 * (1 - u) ** 2 * rate / ramp
    begin = 0.0 if motion.periodic else ramp_phase[-1]
    end = 0.0 if motion.periodic else ramp_phase[-1] + samples / rate
    phase = np.concatenate(
        [
            begin - ramp_phase[-1] + ramp_phase[:-1],
            begin + np.arange(samples) / rate,
            end + ramp_phase[-1] - ramp_phase[::-1],
        ]
    )
    return _Timing(
        phase=speed * phase,
        speed=speed * np.concatenate([ramp_speed[:-1], np.ones(samples), ramp_speed[::-1]]),
        acceleration=speed * np.concatenate([ramp_acceleration[:-1], np.zeros(samples), -ramp_acceleration[::-1]]),
        ramp=ramp,
        samples=samples,
    )


def _joint_states(motion: PlannedMotion, rig: Rig, timing: _Timing) -> tuple[Floats, Floats, Floats, Floats]:
    """Platform position, joint position, speed and acceleration at the instants of `timing`."""
    position, slope, bend = motion.sample(timing.phase)
    velocity: Floats = slope * timing.speed[:, None]
    acceleration: Floats = bend * timing.speed[:, None] ** 2 + slope * timing.acceleration[:, None]
    if motion.space == "joint":
        if (joints := position.shape[1]) != rig.dof:
            raise BadInput(
                f"{motion.name}: a motion of {rig.dof} joints expected, one of {joints} found; choose another"
            )
        return _platform(rig, position), position, velocity, acceleration
    if rig.mechanism != "delta":
        raise BadInput(
            f"{motion.name}: a motion of joints expected for {rig.mechanism}, one of a platform found; ident design "
            "--rig FILE makes one, or write a trajectory file with the columns time,joint_1,...,joint_n"
        )
    theta = kinematics.inverse(rig.geometry, position)
    return position, theta, *kinematics.joint_motion(rig.geometry, theta, position, velocity, acceleration)


def _platform(rig: Rig, position: Floats) -> Floats:
    """Platform position (n, 3) [m] at the joint positions (n, dof); NaN without a platform."""
    if rig.mechanism == "delta":
        return kinematics.forward(rig.geometry, position)
    return np.full((len(position), 3), np.nan)


def _digest(motion: PlannedMotion, geometry: Geometry, rate: float, cycles: int) -> str:
    parts = [motion.definition, geometry.model_dump_json(), rate, cycles, RAMP_SECONDS]
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()
