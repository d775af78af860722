"""Motions as quintic splines through given points; four continuous derivatives keep the torque smooth."""

import json

import numpy as np
from scipy.interpolate import make_interp_spline

from recordings.recording import Floats
from trajectories.motion import PlannedMotion, Space

DEGREE = 5
MIN_POINTS = DEGREE + 2
"""Smallest number of points: one more than the degree requires, because a closed path ends in its first point."""

CLOSED_WITHIN = 1e-6
"""Largest distance between the last and the first point of a periodic motion [m or rad]."""


def closes(points: Floats) -> bool:
    """Whether the last of the points (m, 3) coincides with the first."""
    return bool(np.abs(points[-1] - points[0]).max() <= CLOSED_WITHIN)


def through(name: str, description: str, space: Space, time: Floats, points: Floats) -> PlannedMotion:
    """Build the motion through points (m, 3) at strictly increasing times (m,) [s], m >= MIN_POINTS.

    The motion is periodic if the last point coincides with the first.
    """
    time, periodic = time - time[0], closes(points)
    duration = float(time[-1])
    if periodic:
        points = np.vstack([points[:-1], points[:1]])
    position = make_interp_spline(time, points, k=DEGREE, bc_type="periodic" if periodic else None)
    velocity, acceleration = position.derivative(1), position.derivative(2)

    def sample(phase: Floats) -> tuple[Floats, Floats, Floats]:
        phase = np.mod(phase, duration) if periodic else np.clip(phase, 0, duration)
        return position(phase), velocity(phase), acceleration(phase)

    return PlannedMotion(
        name=name,
        description=description,
        space=space,
        duration=duration,
        periodic=periodic,
        definition=json.dumps({"time": time.tolist(), space: points.tolist()}),
        sample=sample,
    )
