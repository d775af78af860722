"""Motions as quintic splines through given points: four continuous derivatives, so that torque has no kinks."""

import json

import numpy as np
from scipy.interpolate import make_interp_spline

from recordings.recording import Floats
from trajectories.motion import PlannedMotion, Space

DEGREE = 5
MIN_POINTS = DEGREE + 2
"""One more than the degree asks for: where the path closes, the last point is the first."""

CLOSED_WITHIN = 1e-6
"""How near the last point must come to the first for the motion to repeat [m or rad]."""


def closes(points: Floats) -> bool:
    """Whether the points (m, 3) end where they began."""
    return bool(np.abs(points[-1] - points[0]).max() <= CLOSED_WITHIN)


def through(name: str, description: str, space: Space, time: Floats, points: Floats) -> PlannedMotion:
    """The motion through points (m, 3) at strictly increasing times (m,) [s], m >= MIN_POINTS.

    It is periodic where the last point is the first.
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
