"""Tilt of the robot's base."""

from typing import Any

import numpy as np

from ident.dynamics import mechanisms
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects import quantities
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from ident.dynamics.effects.c_code import CCode
from ident.dynamics.mechanisms.urdf import Urdf
from ident.dynamics.platform import GRAVITY
from recordings.recording import Floats


def sideways(q: Any, J: Any, m_p: Any, T_g: Any, m_d: Any, L1: Any, cos_phi: Any, sin_phi: Any) -> Any:
    """Torque per horizontal gravity along x and y: of platform, arms, and rods of known mass.

    An arm that turns by dq moves its centre of mass by -sin q dq along its limb's direction. A rod's centre moves
    half as much as its elbow and half as much as the platform, which carries half of all three.
    """
    arm, platform = (T_g / GRAVITY + m_d / 2 * L1) * np.sin(q), m_p + 3 / 2 * m_d
    return arm * cos_phi - platform * J[0], arm * sin_phi - platform * J[1]


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """(n, dof, 2): of a delta robot the formula, of a tree of links their weight across the stated gravity."""
    mechanism = mechanisms.create(inputs.rig)
    if not isinstance(mechanism, Urdf):
        return quantities.columns(sideways, inputs, shapes)
    parameters = np.array([inputs.parameters[each.name] for each in mechanism.parameters])
    return mechanism.sideways(inputs.motion, parameters, mechanisms.known_masses(inputs.beyond))


effect = Additive(
    sentence="The robot's base is not level, so that weight also pulls sideways.",
    size="{norm} of gravity sideways",
    symptom="The residuals of the joints shift against each other and vary slowly with the robot's pose.",
    causes="a frame that was set up or has settled crooked, a robot mounted at an angle",
    remedy="level the frame, or enter gravity's direction into the controller's model",
    record="slow motion that reaches all sides of the workspace, and one of the empty robot to compare",
    equation="weight of platform and arms, or links, with gravity (g_x, g_y, -g)",
    axis="position",
    mechanisms=("delta", "urdf"),
    whole_robot=True,
    formula=sideways,
    columns=columns,
    c=CCode(of_links="g_x * m->sideways[0][i] + g_y * m->sideways[1][i]"),
    parameters=(
        Quantity(
            name="g_x",
            unit="m/s^2",
            meaning="gravity along x, or the first direction across the stated one",
            lower=-GRAVITY,
            upper=GRAVITY,
        ),
        Quantity(
            name="g_y",
            unit="m/s^2",
            meaning="gravity along y, or the second direction",
            lower=-GRAVITY,
            upper=GRAVITY,
        ),
    ),
    on_arm=True,
    bodies=("g_x", "g_y"),
)
