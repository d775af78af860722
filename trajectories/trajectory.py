"""From a motion to the samples that are streamed: soft start, identical cycles, soft end."""

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
"""How long the start and the end take."""
DEFAULT_SECONDS = 20.0
"""About how long the repetitions take together where their number is not given."""

MIN_RATE = 10.0
"""[Hz]"""
MIN_SAMPLES = 20
"""In one repetition."""
MAX_SAMPLES = 10_000_000
"""In all; hours, and a gigabyte of memory."""


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A motion sampled at the cycle rate, at rest at both ends; arrays have one row per cycle (SYNC)."""

    name: str
    description: str
    digest: str
    """SHA-256 of what defines the samples: the motion, the geometry, rate and cycles."""
    rate: float
    """Samples per second [Hz]."""
    period: float
    """Duration of one repetition [s]; 0 where the motion does not repeat."""
    cycles: int
    """Repetitions."""
    platform: Floats
    """(n, 3) platform position [m]; NaN where the rig has none."""
    joint_position: Floats
    """(n, dof) [rad or m]."""
    joint_velocity: Floats
    """(n, dof) [rad/s or m/s]."""
    joint_acceleration: Floats
    """(n, dof) [rad/s^2 or m/s^2]."""
    repeat: Ints
    """(n,) the repetition a sample belongs to, 0 to cycles - 1; -1 while starting and stopping."""

    @property
    def time(self) -> Floats:
        """(n,) time of each sample from the first [s]."""
        return np.arange(len(self.repeat)) / self.rate


@dataclass(frozen=True)
class _Timing:
    """Phase time of the samples of lead-in, one repetition and lead-out, and its first two time derivatives."""

    phase: Floats
    speed: Floats
    acceleration: Floats
    ramp: int
    """Samples of the lead-in; the lead-out has one more, which stands still."""
    samples: int
    """Samples of one repetition."""


def assemble(motion: PlannedMotion, rig: Rig, cycles: int | None = None, rate: float | None = None) -> Trajectory:
    """Sample `motion` for `rig`, `cycles` times (default: about 20 s) at `rate` [Hz] (default: the rig's).

    The motion's own phase speed is ramped from rest to 1 before the first repetition and back after the last, so
    that all repetitions are the same, sample for sample. A motion that does not repeat is ramped within itself.
    Where the duration is no whole number of samples, it is stretched or shortened to the nearest one.

    Raises:
        BadInput: rate or cycles make no sense for this motion.
        Unreachable: the robot cannot get there, naming the first instant.
    """
    rate = rig.rate if rate is None else rate
    cycles = _default_cycles(motion) if cycles is None else cycles
    _refuse_nonsense(motion, cycles, rate)
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


def _default_cycles(motion: PlannedMotion) -> int:
    return max(1, round(DEFAULT_SECONDS / motion.duration)) if motion.periodic else 1


def _refuse_nonsense(motion: PlannedMotion, cycles: int, rate: float) -> None:
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
    # Phase seconds per second: 1 but for rounding the duration to whole samples.
    speed = motion.duration * rate / (samples if motion.periodic else samples + ramp)
    u = np.arange(ramp + 1) / ramp
    # Smootherstep, its integral and derivative: phase speed joins rest and full speed without a jump in jerk.
    eased = u**3 * (10 - 15 * u + 6 * u**2)
    travelled = (u**4 * (2.5 - 3 * u + u**2)) * ramp / rate
    surge = 30 * u**2 * (1 - u) ** 2 * rate / ramp
    begin = 0.0 if motion.periodic else travelled[-1]
    end = 0.0 if motion.periodic else travelled[-1] + samples / rate
    phase = np.concatenate(
        [
            begin - travelled[-1] + travelled[:-1],
            begin + np.arange(samples) / rate,
            end + travelled[-1] - travelled[::-1],
        ]
    )
    return _Timing(
        phase=speed * phase,
        speed=speed * np.concatenate([eased[:-1], np.ones(samples), eased[::-1]]),
        acceleration=speed * np.concatenate([surge[:-1], np.zeros(samples), -surge[::-1]]),
        ramp=ramp,
        samples=samples,
    )


def _joint_states(motion: PlannedMotion, rig: Rig, timing: _Timing) -> tuple[Floats, Floats, Floats, Floats]:
    """Platform position, joint position, speed and acceleration at the instants of `timing`."""
    position, slope, bend = motion.sample(timing.phase)
    velocity: Floats = slope * timing.speed[:, None]
    acceleration: Floats = bend * timing.speed[:, None] ** 2 + slope * timing.acceleration[:, None]
    if motion.space == "joint":
        _refuse_other_joints(motion, position.shape[1], rig)
        return _platform(rig, position), position, velocity, acceleration
    if rig.mechanism != "delta":
        raise BadInput(f"{motion.name}: a motion of joints expected for {rig.mechanism}, one of a platform found")
    theta = kinematics.inverse(rig.geometry, position)
    return position, theta, *kinematics.joint_motion(rig.geometry, theta, position, velocity, acceleration)


def _refuse_other_joints(motion: PlannedMotion, joints: int, rig: Rig) -> None:
    if joints != rig.dof:
        raise BadInput(f"{motion.name}: a motion of {rig.dof} joints expected, one of {joints} found; choose another")


def _platform(rig: Rig, position: Floats) -> Floats:
    """(n, 3) [m] at the joint positions (n, dof); NaN where there is no platform."""
    if rig.mechanism == "delta":
        return kinematics.forward(rig.geometry, position)
    return np.full((len(position), 3), np.nan)


def _digest(motion: PlannedMotion, geometry: Geometry, rate: float, cycles: int) -> str:
    parts = [motion.definition, geometry.model_dump_json(), rate, cycles, RAMP_SECONDS]
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()
