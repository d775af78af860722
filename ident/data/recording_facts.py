"""What a recording holds: sampling, resolution, and which motions and torques occur."""

from collections.abc import Sequence

import numpy as np
from pydantic import Field

from ident.data.prepared_recording import PreparedRecording
from recordings.config import ConfigSection
from recordings.recording import Floats

MOVING = 0.02
"""A joint moves where it is faster than this share of its highest speed."""
_FASTEST = 0.99
"""Quantile of the speed that counts as the highest: one wrong reading is no speed."""


class JointFacts(ConfigSection):
    """Motion and torque of one joint, as documents state them."""

    joint: str
    """Its name."""
    position_unit: str
    effort_unit: str
    travel: float
    """Between the outermost positions [rad or m]."""
    highest_speed: float
    """[rad/s or m/s]"""
    speed_spread: float
    """Standard deviation of the speed while it moves, relative to its mean: 0 for one speed only."""
    forward_share: float
    """Share of the moving time in positive direction, 0 to 1."""
    encoder_step: float | None
    """[rad or m]; None where the readings are continuous."""
    drive_step: float | None
    """Of the voltage [V] or of the effort; None where it is continuous."""
    torque_rms: float
    """[N m or N]"""
    torque_spread: float = Field(exclude=True)
    """Standard deviation of the torque, relative to its RMS: 0 for a load that does not change."""

    @property
    def rarer_direction(self) -> float:
        """Share of the moving time in the rarer direction, 0 to 0.5."""
        return min(self.forward_share, 1 - self.forward_share)


class RecordingFacts(ConfigSection):
    """Sampling and joints of one recording, or of several together, as documents state them."""

    file: str
    """The first one."""
    simulated: bool
    rate_hz: float
    jitter: float
    """Standard deviation of the steps of time, relative to their median."""
    duration_s: float
    cycles: int
    """0 if nothing repeats."""
    joints: tuple[JointFacts, ...] = Field(exclude=True)


def recording_facts(prepared: Sequence[PreparedRecording]) -> RecordingFacts:
    """Facts about the `prepared` recordings, or excerpts, together."""
    first = prepared[0].recording
    return RecordingFacts(
        file=str(first.path),
        simulated=first.run.simulated,
        rate_hz=prepared[0].samples.rate,
        jitter=max(_jitter(each.recording.time) for each in prepared),
        duration_s=sum(float(np.ptp(each.recording.time)) for each in prepared),
        cycles=first.run.cycles,
        joints=tuple(_joint_facts(prepared, joint) for joint in range(first.rig.dof)),
    )


def _jitter(time: Floats) -> float:
    """Relative standard deviation of the steps of `time` (n,), without those across gaps."""
    steps = np.diff(time)
    median = float(np.median(steps))
    return float(np.std(steps[steps < 1.9 * median])) / median


def _joint_facts(prepared: Sequence[PreparedRecording], joint: int) -> JointFacts:
    rig = prepared[0].recording.rig
    rows = [each.usable[:, joint] for each in prepared]
    position, velocity, torque = (
        np.concatenate([signal[used, joint] for signal, used in zip(signals, rows, strict=True)])
        for signals in (
            [each.motion.position for each in prepared],
            [each.motion.velocity for each in prepared],
            [each.torque for each in prepared],
        )
    )
    speed = np.abs(velocity)
    highest = float(np.quantile(speed, _FASTEST))
    moving = speed > MOVING * highest
    rms = float(np.sqrt(np.mean(torque**2)))
    return JointFacts(
        joint=rig.joint_names[joint],
        position_unit=rig.position_units[joint],
        effort_unit=rig.effort_units[joint],
        travel=float(np.ptp(position)),
        highest_speed=highest,
        speed_spread=float(speed[moving].std() / speed[moving].mean()) if moving.any() else 0.0,
        forward_share=float(np.mean(velocity[moving] > 0)) if moving.any() else 0.0,
        encoder_step=max(float(each.encoder_step[joint]) for each in prepared) or None,
        drive_step=max(float(each.drive_step[joint]) for each in prepared) or None,
        torque_rms=rms,
        torque_spread=float(torque.std()) / rms if rms else 0.0,
    )
