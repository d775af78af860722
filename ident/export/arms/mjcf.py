"""MJCF of an identified arm: one body for each driven joint, with what is fixed to it."""

from collections.abc import Mapping
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ident.dynamics.rigid_chain import joint_axis
from ident.export.arms.bodies import Arm, about_centre, added_to_bodies
from ident.export.xml_file import text
from ident.identification.model import Model
from recordings.recording import Floats

BODIES = ("g_x", "g_y", "stiffness", "torque_at_zero", "zero")
"""What effects add to: gravity across the stated one [m/s^2], stiffness and torque at zero of a joint's spring, and
the zero of its encoder."""
_TIMESTEP = 1e-3
"""Of the simulation [s]."""


def document(model: Model, arm: Arm) -> Element:
    """The whole model."""
    added = added_to_bodies(model, BODIES)
    root = Element("mujoco", model="arm")
    SubElement(root, "compiler", angle="radian", autolimits="true")
    across = arm.mechanism.across
    gravity = np.array(arm.mechanism.chain.gravity) + np.array([added["g_x"][0], added["g_y"][0]]) @ across
    SubElement(root, "option", timestep=text([_TIMESTEP]), gravity=text(gravity), integrator="implicitfast")
    bodies = [SubElement(root, "worldbody")]
    actuator = SubElement(root, "actuator")
    links = arm.mechanism.links
    for number in range(1, links.model.njoints):
        index = int(np.flatnonzero(links.order == number - 1)[0])
        bodies.append(_body(bodies[links.model.parents[number]], arm, number, index, added))
        name = arm.mechanism.chain.joints[index]
        SubElement(actuator, "motor", name=name, joint=name)
    return root


def _body(parent: Element, arm: Arm, number: int, index: int, added: Mapping[str, Floats]) -> Element:
    """The body that joint `number` of Pinocchio's model, `index` of the recording, moves."""
    import pinocchio

    links, name = arm.mechanism.links, arm.mechanism.chain.joints[index]
    place = links.model.jointPlacements[number]
    x, y, z, w = pinocchio.Quaternion(place.rotation).coeffs()
    body = SubElement(parent, "body", name=name, pos=text(place.translation), quat=text([w, x, y, z]))
    stiffness, constant = added["stiffness"][index], added["torque_at_zero"][index]
    SubElement(
        body, "joint", name=name, type="slide" if arm.mechanism.chain.types[index] == "prismatic" else "hinge",
        axis=text(joint_axis(links, number)), armature=text([arm.motors[index]]),
        damping=text([arm.friction["viscous"][index]]), frictionloss=text([arm.friction["coulomb"][index]]),
        ref=text([added["zero"][index]]), stiffness=text([stiffness]),
        springref=text([-constant / stiffness if stiffness else 0.0]),
    )  # fmt: skip
    mass, centre, inertia = about_centre(arm.links[index])
    full = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    SubElement(body, "inertial", mass=text([mass]), pos=text(centre), fullinertia=text(full))
    return body
