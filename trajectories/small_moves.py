"""Small motions of one joint from the pose in which the robot stands, for commissioning: the other joints hold."""

import math

import numpy as np

from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Rig
from trajectories.approach import GENTLE_ACCELERATION
from trajectories.checks import LimitExceeded, check, usage
from trajectories.motion import PlannedMotion, of_one_joint
from trajectories.trajectory import RAMP_SECONDS, Trajectory, assemble

LARGEST = 0.5
"""Largest angle of one jog [rad]: an error in counts_per_turn or gear multiplies it."""
SPEED = 0.1
"""Joint speed of a jog [rad/s]: 35 mm/s at the elbow of the default robot."""
SWINGS = 6


def jog(rig: Rig, pose: Floats, joint: int, by: float, speed: float = SPEED) -> Trajectory:
    """Move `joint` (1 ... n) by `by` [rad or m] at `speed`, with a soft start and end of one second.

    Raises:
        BadInput: there is no such joint.
    """
    duration = max(2 * RAMP_SECONDS, abs(by) / speed)
    sample = of_one_joint(
        rig, joint, pose, lambda time: (by * time / duration, np.full_like(time, by / duration), np.zeros_like(time))
    )
    description = f"joint {joint} by {by:+g} {rig.position_units[joint - 1]}"
    motion = PlannedMotion(f"jog-{joint}", description, "joint", duration, False, repr((joint, by, speed)), sample)
    return assemble(motion, rig, 1)


def swing(rig: Rig, pose: Floats, joint: int, amplitude: float) -> Trajectory:
    """Swing `joint` about its pose by ±`amplitude` [rad or m], so that weight, inertia and friction show.

    Raises:
        BadInput: there is no such joint.
    """
    omega = math.sqrt(GENTLE_ACCELERATION / amplitude)

    def derivative(order: int, time: Floats) -> Floats:
        return amplitude * omega**order * np.sin(omega * time + order * np.pi / 2)

    sample = of_one_joint(
        rig, joint, pose, lambda time: (derivative(0, time), derivative(1, time), derivative(2, time))
    )
    description = f"joint {joint} by ±{amplitude:g} {rig.position_units[joint - 1]}"
    period, definition = 2 * math.pi / omega, repr((joint, amplitude))
    motion = PlannedMotion(f"axis-check-{joint}", description, "joint", period, True, definition, sample)
    return assemble(motion, rig, SWINGS)


def within_limits(trajectory: Trajectory, rig: Rig) -> Trajectory:
    """`trajectory`, if it exceeds no limit; from a pose beyond a limit (a robot that hangs low) the way back is free.

    Raises:
        BadInput: a limit is exceeded.
    """
    shares = usage(trajectory, rig)
    if any(share.max() > max(1.0, share[0]) or np.isnan(share).any() for share in shares.values()):
        try:
            check(trajectory, rig)
        except LimitExceeded as error:
            raise BadInput(f"{error}; a smaller step or the other direction may be possible") from None
    return trajectory
