"""A base that does not stand level."""

import numpy as np

from ident.dynamics import rods
from ident.dynamics.effect_inputs import GRAVITY, EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from recordings.recording import Floats


def columns(view: EffectInputs, shapes: Shapes) -> Floats:
    """Torque per horizontal gravity along x and y (n, dof, 2), on platform, arms and, where it is known, forearms."""
    mass, moment = view.parameters["m_p"], view.parameters["T_g"] / GRAVITY
    platform = -mass * view.platform.jacobian[:, :2]
    # An arm's centre of mass moves by -sin q along its limb's direction when the arm turns.
    along = np.stack([np.cos(view.rig.geometry.phi), np.sin(view.rig.geometry.phi)])
    arms = moment * np.sin(view.motion.position)[:, None, :] * along
    forearms = view.parameters["m_d"] * rods.horizontal_gravity_torque(view.rig.geometry, view.motion)
    both: Floats = (platform + arms + forearms).swapaxes(1, 2)
    return both


effect = Additive(
    sentence="The robot's base is not level, so that weight also pulls sideways.",
    symptom="The residuals of the joints shift against each other and vary slowly with the platform's place.",
    causes="a frame that was set up or has settled crooked, a robot mounted at an angle",
    remedy="level the frame, or enter gravity's direction into the controller's model",
    equation="weight of platform and arms with gravity (g_x, g_y, -g)",
    axis="position",
    mechanisms=("delta",),
    whole_robot=True,
    coefficients=(
        Quantity(name="g_x", unit="m/s^2", meaning="gravity along x", lower=-GRAVITY, upper=GRAVITY),
        Quantity(name="g_y", unit="m/s^2", meaning="gravity along y", lower=-GRAVITY, upper=GRAVITY),
    ),
    columns=columns,
)
