"""Tilt of the robot's base."""

from typing import Any

import numpy as np

from ident.dynamics.effects.base import Additive, Quantity
from ident.dynamics.platform import GRAVITY


def sideways(q: Any, J: Any, m_p: Any, T_g: Any, m_d: Any, L1: Any, cos_phi: Any, sin_phi: Any) -> Any:
    """Torque per horizontal gravity along x and y: of platform, arms, and rods of known mass.

    An arm that turns by dq moves its centre of mass by -sin q dq along its limb's direction. A rod's centre moves
    half as much as its elbow and half as much as the platform, which carries half of all three.
    """
    arm, platform = (T_g / GRAVITY + m_d / 2 * L1) * np.sin(q), m_p + 3 / 2 * m_d
    return arm * cos_phi - platform * J[0], arm * sin_phi - platform * J[1]


effect = Additive(
    sentence="The robot's base is not level, so that weight also pulls sideways.",
    symptom="The residuals of the joints shift against each other and vary slowly with the platform's place.",
    causes="a frame that was set up or has settled crooked, a robot mounted at an angle",
    remedy="level the frame, or enter gravity's direction into the controller's model",
    equation="weight of platform and arms with gravity (g_x, g_y, -g)",
    axis="position",
    mechanisms=("delta",),
    whole_robot=True,
    formula=sideways,
    parameters=(
        Quantity(name="g_x", unit="m/s^2", meaning="gravity along x", lower=-GRAVITY, upper=GRAVITY),
        Quantity(name="g_y", unit="m/s^2", meaning="gravity along y", lower=-GRAVITY, upper=GRAVITY),
    ),
    on_arm=True,
    bodies=("g_x", "g_y"),
)
