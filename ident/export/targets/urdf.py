"""URDF of an identified arm: the file of the rig with the inertial values and friction that were identified.

Each driven link carries what is fixed to it. Joints that are not driven become fixed where they stand. A motor's
inertia stands where Drake reads it, `drake:rotor_inertia` of a transmission; URDF itself has no place for it, nor for
gravity and constant torques.
"""

from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ident.export.arms.bodies import Arm, about_centre, arm_of, carried_by
from ident.export.losses import Carried
from ident.export.targets import ExportRequest
from ident.export.targets import beside as carried_file
from ident.export.xml_file import text, write_xml
from recordings.recording import Floats
from recordings.urdf_joints import read_joints, robot_of

__all__ = ["carried_file", "write"]

_DRAKE = "http://drake.mit.edu"
"""Namespace of Drake's elements."""


def write(request: ExportRequest) -> Carried:
    """See `Target`.

    Raises:
        BadInput: the model is not one of a URDF.
    """
    arm = arm_of(request.model, request.path)
    chain = arm.mechanism.chain
    robot = robot_of(chain.urdf)
    children = {joint.name: joint.child for joint in read_joints(chain.urdf)}
    for link in robot.findall("link"):
        for inertial in link.findall("inertial"):
            link.remove(inertial)
    for index, name in enumerate(chain.joints):
        link = next(each for each in robot.findall("link") if each.get("name") == children[name])
        link.insert(0, _inertial(arm.links[index]))
    for joint in robot.findall("joint"):
        name = joint.get("name", "")
        if name in chain.joints:
            _set_dynamics(robot, joint, arm, chain.joints.index(name))
        elif joint.get("type") != "fixed":
            _fix(joint, chain.standing.get(name, 0.0))
    ElementTree.register_namespace("drake", _DRAKE)
    write_xml(robot, request.out)
    return carried_by(request.model, arm, (), "URDF")


def _inertial(parameters: Floats) -> Element:
    """The element of a link with `LINK_PARAMETERS` (10,): its inertia is about the centre of mass."""
    mass, place, inertia = about_centre(parameters)
    element = Element("inertial")
    SubElement(element, "origin", xyz=text(place), rpy="0 0 0")
    SubElement(element, "mass", value=text([mass]))
    entries = {f"i{'xyz'[i]}{'xyz'[j]}": text([inertia[i, j]]) for i in range(3) for j in range(i, 3)}
    SubElement(element, "inertia", entries)
    return element


def _set_dynamics(robot: Element, joint: Element, arm: Arm, index: int) -> None:
    for old in joint.findall("dynamics"):
        joint.remove(old)
    damping, friction = (text([arm.friction[name][index]]) for name in ("viscous", "coulomb"))
    SubElement(joint, "dynamics", damping=damping, friction=friction)
    transmission = SubElement(robot, "transmission", name=f"motor_{joint.get('name')}")
    SubElement(transmission, "type").text = "transmission_interface/SimpleTransmission"
    SubElement(transmission, "joint", name=joint.get("name", ""))
    actuator = SubElement(transmission, "actuator", name=f"motor_{joint.get('name')}")
    SubElement(actuator, f"{{{_DRAKE}}}rotor_inertia", value=text([arm.motors[index]]))


def _fix(joint: Element, position: float) -> None:
    """Make `joint` a fixed one at a `position` [rad or m]."""
    from scipy.spatial.transform import Rotation

    origin, axis = joint.find("origin"), joint.find("axis")
    if origin is None:
        origin = SubElement(joint, "origin")
    place, angles = (np.array([float(x) for x in origin.get(key, "0 0 0").split()]) for key in ("xyz", "rpy"))
    along = np.array([1.0, 0.0, 0.0] if axis is None else [float(x) for x in axis.get("xyz", "").split()])
    along, turn = along / np.linalg.norm(along), Rotation.from_euler("xyz", angles)
    if joint.get("type") == "prismatic":
        place = place + turn.apply(position * along)
    else:
        turn = turn * Rotation.from_rotvec(position * along)
    origin.set("xyz", text(place))
    origin.set("rpy", text(turn.as_euler("xyz")))
    joint.set("type", "fixed")
    for tag in ("axis", "limit", "mimic", "dynamics", "calibration", "safety_controller"):
        for part in joint.findall(tag):
            joint.remove(part)
