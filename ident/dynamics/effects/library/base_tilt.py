"""Tilt of the robot's base."""

import numpy as np

from ident.dynamics import rods
from ident.dynamics.effect_inputs import GRAVITY, EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from ident.dynamics.effects.c_code import CCode
from recordings.recording import Floats


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """Torque (n, dof, 2) per horizontal gravity along x and y: of platform, arms, and rods of known mass."""
    mass, moment = inputs.parameters["m_p"], inputs.parameters["T_g"] / GRAVITY
    platform = -mass * inputs.platform.jacobian[:, :2]
    # An arm that turns by dq moves its centre of mass by -sin q dq along its limb's direction.
    along = np.stack([np.cos(inputs.rig.geometry.phi), np.sin(inputs.rig.geometry.phi)])
    arms = moment * np.sin(inputs.motion.position)[:, None, :] * along
    of_rods = inputs.parameters["m_d"] * rods.horizontal_gravity_torque(inputs.rig.geometry, inputs.motion)
    torque: Floats = (platform + arms + of_rods).swapaxes(1, 2)
    return torque


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
    on_arm=True,
    c=CCode(
        statements="""
            const real moment = T_g / R(9.81) * sin(q), rod = m_d / 2, turn = L1 * sin(q);
            const real x = (moment + rod * turn) * cos_phi - (m_p + 3 * rod) * J[i][0];
            const real y = (moment + rod * turn) * sin_phi - (m_p + 3 * rod) * J[i][1];""",
        expression="g_x * x + g_y * y",
    ),
)
