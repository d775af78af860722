"""Forearms of uniform mass, where the base model has their mass in lumps at platform and arms."""

import numpy as np

from ident.effects import Additive, Quantity, Shapes
from ident.view import GRAVITY, View
from recordings.recording import Floats


def columns(view: View, shapes: Shapes) -> Floats:
    """Torque that moves and lifts one uniform rod of 1 kg in each limb (n, dof, 1).

    A rod whose ends accelerate with a_1 (elbow) and a_2 (platform) resists with m (2 a_1 + a_2) / 6 at the elbow and
    m (a_1 + 2 a_2) / 6 at the platform; the same for its weight.
    """
    platform, lift = view.platform, np.array([0.0, 0.0, GRAVITY])
    a_2 = (platform.acceleration + lift)[:, None]
    tangent, a_1 = _elbows(view)
    a_1 = a_1 + lift
    at_elbow = np.einsum("njx,njx->nj", tangent, 2 * a_1 + a_2) / 6
    at_platform = ((a_1 + 2 * a_2) / 6).sum(axis=1)
    torque: Floats = at_elbow + np.einsum("nxj,nx->nj", platform.jacobian, at_platform)
    return torque[:, :, None]


def _elbows(view: View) -> tuple[Floats, Floats]:
    """Velocity per joint speed (n, 3, 3), and acceleration (n, 3, 3), of the elbow of each limb."""
    motion, geometry = view.motion, view.rig.geometry
    out = np.stack([np.cos(geometry.phi), np.sin(geometry.phi), np.zeros(3)], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    sine, cosine = (f(motion.position)[:, :, None] for f in (np.sin, np.cos))
    tangent = geometry.L1 * (cosine * up - sine * out)
    inward = -geometry.L1 * (cosine * out + sine * up)
    acceleration = tangent * motion.acceleration[:, :, None] + inward * motion.velocity[:, :, None] ** 2
    return tangent, acceleration


effect = Additive(
    sentence="The forearms' mass is spread over their length, not gathered at their ends.",
    looks="The residual follows accelerations, in all joints, a few per mille to percent of the torque.",
    causes="every real delta robot has it; the base model of the paper leaves it out",
    remedy="add it to the model; nothing is wrong with the machine",
    equation="m_d times the inertia and weight of a uniform rod in each limb, m_d >= 0",
    axis="acceleration",
    mechanisms=("delta",),
    whole_robot=True,
    always_true=True,
    coefficients=(Quantity(name="m_d", unit="kg", meaning="mass of the two rods of one limb", lower=0.0),),
    columns=columns,
)
