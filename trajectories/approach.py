"""The soft move from the present pose of the robot to the start of a trajectory."""

import numpy as np

from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Limits

GENTLE_SPEED = 1.0
"""Largest joint speed of a gentle move [rad/s]."""
GENTLE_ACCELERATION = 4.0
"""Largest joint acceleration of a gentle move [rad/s^2]."""


def approach(start: Floats, goal: Floats, limits: Limits, rate: float) -> Floats:
    """Compute joint positions (m, 3) [rad] from `start` (3,) to `goal` (3,), at rest at both ends; m >= 1.

    All joints follow the same quintic in time. Speed and acceleration exceed neither the gentle values nor half
    of `limits`. The first row is `start`, the last is `goal`.

    Raises:
        BadInput: start or goal holds NaN (a drive whose position is not known).
    """
    start, goal = np.asarray(start, dtype=np.float64), np.asarray(goal, dtype=np.float64)
    if not np.isfinite([start, goal]).all():
        raise BadInput(f"finite joint angles expected, {start.tolist()} and {goal.tolist()} found; check the drives")
    distance = float(np.abs(goal - start).max())
    # Peaks of the quintic: speed 15/8 of the mean speed, acceleration 10/sqrt(3) of distance / duration^2.
    speed = min(GENTLE_SPEED, limits.speed / 2)
    acceleration = min(GENTLE_ACCELERATION, limits.acceleration / 2)
    duration = max(15 / 8 * distance / speed, np.sqrt(10 / np.sqrt(3) * distance / acceleration))
    steps = int(np.ceil(duration * rate))
    u = np.arange(steps + 1) / max(steps, 1)
    share = u**3 * (10 - 15 * u + 6 * u**2)
    path: Floats = start + share[:, None] * (goal - start)
    path[-1] = goal
    return path
