"""What a recording holds of the robot for programs that draw it: its URDF, and the transforms of its links.

A delta robot is a closed chain, which a URDF cannot hold: here it is a tree in which each rod hangs on its arm, and
the platform on the base. Angles of the rods and place of the platform, computed from those of the arms, close it.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

import numpy as np

from recordings import schemas
from recordings.cdr import Encoder, parse_schema
from recordings.recording import Floats
from recordings.rig import Geometry, Rig
from recordings.urdf_joints import robot_of

PLATFORM = ("platform_x", "platform_y", "platform_z")
"""Joints that move the platform along the axes of the base [m]."""
_AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}
_RADII = {"arm": 0.02, "rod": 0.008}
"""Of what is drawn [m]."""


@dataclass(frozen=True, eq=False)
class Frame:
    """The frame of a link, as its joint places it in that of its parent."""

    joint: str
    moves: str
    """Type of the joint; "fixed" if it never moves."""
    parent: str
    child: str
    place: Floats
    """(3,) [m]"""
    turn: Floats
    """(4,) quaternion x, y, z, w."""
    axis: Floats
    """(3,)"""


def urdf_of(rig: Rig) -> str | None:
    """Text of the URDF of the rig's mechanism; None for axes, whose place in space nothing says."""
    if rig.mechanism == "delta":
        return _delta(rig.geometry, rig.joint_names)
    return rig.urdf or None


def frames(urdf: str) -> tuple[Frame, ...]:
    """The frames of the links of a `urdf`, in the order of its joints."""
    return tuple(map(_frame, robot_of(urdf).findall("joint")))


def placed(frame: Frame, position: Floats) -> tuple[Floats, Floats]:
    """Place (n, 3) [m] and quaternion (n, 4) of a frame in that of its parent, by the joint's `position` (n,)."""
    n = len(position)
    if frame.moves == "prismatic":
        direction = _turned(frame.turn, frame.axis)
        return frame.place + position[:, None] * direction, np.tile(frame.turn, (n, 1))
    half = position / 2
    about = np.column_stack([np.sin(half)[:, None] * frame.axis, np.cos(half)])
    return np.tile(frame.place, (n, 1)), _product(np.tile(frame.turn, (n, 1)), about)


def description_messages(rig: Rig) -> dict[str, bytes]:
    """The messages of /robot_description and /tf_static, by topic; none for a mechanism that has no URDF.

    The stamp of what never moves is 0, so that the messages are the same in every recording of the rig."""
    urdf = urdf_of(rig)
    if urdf is None:
        return {}
    text = Encoder(parse_schema(schemas.STRING), {"data": urdf}, {}).pack([])
    fixed = [frame for frame in frames(urdf) if frame.moves == "fixed"]
    at = {frame.child: (frame.place, frame.turn) for frame in fixed}
    return {"/robot_description": text, "/tf_static": TransformEncoder(fixed).pack(0, at)}


class TransformEncoder:
    """Packs messages of tf2_msgs/msg/TFMessage for given frames."""

    def __init__(self, of: Sequence[Frame]) -> None:
        self._children = [frame.child for frame in of]
        texts: dict[str, str] = {}
        for number, frame in enumerate(of):
            texts |= {f"t{number}.header.frame_id": frame.parent, f"t{number}.child_frame_id": frame.child}
        # On the wire, a sequence is its length and its elements: as a message with a field for each of them.
        elements = "".join(f"geometry_msgs/TransformStamped t{number}\n" for number in range(len(of)))
        self._encoder = Encoder(parse_schema(schemas.transforms(f"uint32 count\n{elements}")), texts, {})

    def pack(self, stamp_ns: int, placed: Mapping[str, tuple[Floats, Floats]]) -> bytes:
        """Pack the place (3,) and quaternion (4,) of each frame, by its name."""
        values: list[Any] = [len(self._children)]
        for child in self._children:
            place, turn = placed[child]
            values += [*divmod(stamp_ns, 10**9), *place, *turn]
        return self._encoder.pack(values)


def _frame(joint: ElementTree.Element) -> Frame:
    origin, axis = joint.find("origin"), joint.find("axis")
    place, angles = (
        np.zeros(3) if origin is None else np.array(origin.get(key, "0 0 0").split(), float) for key in ("xyz", "rpy")
    )
    along = np.array([1.0, 0.0, 0.0] if axis is None else axis.get("xyz", "1 0 0").split(), float)
    turn = np.array([0.0, 0.0, 0.0, 1.0])
    for angle, index in zip(angles[::-1], (2, 1, 0), strict=True):  # about fixed axes: x first
        half = np.zeros(4)
        half[[index, 3]] = math.sin(angle / 2), math.cos(angle / 2)
        turn = _product(turn, half)
    parent, child = (joint.find(name) for name in ("parent", "child"))
    assert parent is not None
    assert child is not None
    names = joint.get("name", ""), joint.get("type", ""), parent.get("link", ""), child.get("link", "")
    return Frame(*names, place, turn, along / np.linalg.norm(along))


def _product(a: Floats, b: Floats) -> Floats:
    """Quaternions (..., 4) of the turn `b` followed by the turn `a`."""
    va, wa, vb, wb = a[..., :3], a[..., 3:], b[..., :3], b[..., 3:]
    vector = wa * vb + wb * va + np.cross(va, vb)
    return np.concatenate([vector, wa * wb - (va * vb).sum(axis=-1, keepdims=True)], axis=-1)


def _turned(turn: Floats, vector: Floats) -> Floats:
    """`vector` (3,) turned by a quaternion (4,)."""
    twice = 2 * np.cross(turn[:3], vector)
    return vector + turn[3] * twice + np.cross(turn[:3], twice)


def _delta(geometry: Geometry, joints: Sequence[str]) -> str:
    robot = ElementTree.Element("robot", name="delta")
    _link(robot, "base", 0.02, geometry.R)
    for number, (name, phi) in enumerate(zip(joints, geometry.phi, strict=True), start=1):
        arm, fork, rod = (f"{part}_{number}" for part in ("arm", "fork", "rod"))
        around = f"{geometry.R * math.cos(phi)!r} {geometry.R * math.sin(phi)!r} 0"
        # Angles are positive upwards, so about -y.
        _joint(robot, name, "continuous", ("base", arm), around, f"0 0 {phi!r}", "0 -1 0")
        _joint(robot, f"lift_{number}", "continuous", (arm, fork), f"{geometry.L1!r} 0 0", "0 0 0", _AXES["y"])
        _joint(robot, f"swing_{number}", "continuous", (fork, rod), "0 0 0", "0 0 0", _AXES["z"])
        _link(robot, arm, geometry.L1, _RADII["arm"], along=True)
        _link(robot, fork)
        _link(robot, rod, geometry.L2, _RADII["rod"], along=True)
        place = f"{geometry.r * math.cos(phi)!r} {geometry.r * math.sin(phi)!r} 0"
        _joint(robot, f"end_{number}", "fixed", ("platform", f"rod_end_{number}"), place, "0 0 0")
        _link(robot, f"rod_end_{number}")
    links = ["base", *PLATFORM[:2], "platform"]
    for name, axis, *pair in zip(PLATFORM, _AXES.values(), links, links[1:], strict=False):
        joint = _joint(robot, name, "prismatic", pair, "0 0 0", "0 0 0", axis)
        reach = repr(geometry.R + geometry.L1 + geometry.L2)
        ElementTree.SubElement(joint, "limit", lower=f"-{reach}", upper=reach, effort="0", velocity="0")
    for name in PLATFORM[:2]:
        _link(robot, name)
    _link(robot, "platform", 0.01, geometry.r)
    return ElementTree.tostring(robot, encoding="unicode")


def _link(
    robot: ElementTree.Element, name: str, length: float = 0.0, radius: float = 0.0, *, along: bool = False
) -> None:
    """Add a link, drawn as a cylinder if it has a length: `along` its x axis, else about its z axis."""
    link = ElementTree.SubElement(robot, "link", name=name)
    if length:
        visual = ElementTree.SubElement(link, "visual")
        if along:
            ElementTree.SubElement(visual, "origin", xyz=f"{length / 2!r} 0 0", rpy=f"0 {math.pi / 2!r} 0")
        shape = ElementTree.SubElement(visual, "geometry")
        ElementTree.SubElement(shape, "cylinder", length=repr(length), radius=repr(radius))


def _joint(
    robot: ElementTree.Element,
    name: str,
    kind: str,
    links: Sequence[str],
    xyz: str,
    rpy: str,
    axis: str | None = None,
) -> ElementTree.Element:
    joint = ElementTree.SubElement(robot, "joint", name=name, type=kind)
    ElementTree.SubElement(joint, "origin", xyz=xyz, rpy=rpy)
    ElementTree.SubElement(joint, "parent", link=links[0])
    ElementTree.SubElement(joint, "child", link=links[1])
    if axis:
        ElementTree.SubElement(joint, "axis", xyz=axis)
    return joint
