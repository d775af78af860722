"""Identification path, in the role of Fig. 5a: picking and placing between five stations."""

import numpy as np

from trajectories.motion import PlannedMotion
from trajectories.spline import through

WAYPOINTS = np.array(
    [  # time, x, y, z
        [0.00, -0.28, -0.12, -0.78],
        [0.35, -0.02, -0.04, -0.58],
        [0.75, 0.27, 0.08, -0.76],
        [1.15, 0.10, 0.16, -0.64],
        [1.50, -0.10, 0.27, -0.74],
        [1.90, 0.02, 0.00, -0.56],
        [2.25, 0.12, -0.27, -0.78],
        [2.65, 0.08, -0.06, -0.68],
        [2.95, 0.05, 0.06, -0.80],
        [3.45, -0.12, -0.04, -0.60],
        [4.00, -0.28, -0.12, -0.78],
    ]
)
"""Time [s] and platform position [m]. The figure gives no coordinates; these values are our own."""


def motion() -> PlannedMotion:
    """Build five moves of different length and speed, each raised in the middle."""
    return through(
        "fig5a",
        "pick and place between five stations (identification)",
        "platform",
        WAYPOINTS[:, 0],
        WAYPOINTS[:, 1:],
    )
