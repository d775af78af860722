"""The joints of a URDF: a tree of links with joints of one direction each, and which of them mimic others."""

import math
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal
from xml.etree import ElementTree

JointType = Literal["revolute", "prismatic"]

_MOVABLE: dict[str, JointType] = {"revolute": "revolute", "continuous": "revolute", "prismatic": "prismatic"}
_NUMBERS = {
    **{"xyz": 3, "rpy": 3, "value": 1, "multiplier": 1, "offset": 1},
    **dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), 1),
}
"""Attributes of joints and inertial values that hold so many numbers."""
_INERTIAL = {"mass": ("value",), "inertia": ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")}
"""What inertial values consist of."""
_REFUSED = {
    "floating": "a robot that stands on the ground expected; make the joint fixed",
    "planar": "joints with one direction of motion expected; make it two prismatic joints and a revolute one",
}


@dataclass(frozen=True)
class UrdfJoint:
    """A joint of a URDF."""

    name: str
    type: JointType | None
    """None for a fixed joint."""
    parent: str
    child: str
    mimics: str | None
    """Name of the joint whose motion it repeats."""
    multiplier: float
    """Its position per position of that joint."""
    offset: float
    """Its position where that joint is at 0 [rad or m]."""
    limits: tuple[float, float] | None
    """Lowest and highest position [rad or m]; None where none are stated."""


def robot_of(text: str) -> ElementTree.Element:
    """Return the root of a URDF without what nobody reads: its own namespace, and axes of fixed joints, often 0."""
    robot = ElementTree.fromstring(text)
    own = robot.tag.rpartition("}")[0] + "}"
    for element in robot.iter():
        element.tag = element.tag.removeprefix(own)
    for joint in robot.findall("joint[@type='fixed']"):
        for axis in joint.findall("axis"):
            joint.remove(axis)
    return robot


@lru_cache(maxsize=16)
def read_joints(text: str) -> tuple[UrdfJoint, ...]:
    """Return the joints of a URDF, in the order of the file.

    Raises:
        ValueError: it is no URDF of a tree of links with joints of one direction each.
    """
    try:
        robot = robot_of(text)
    except ElementTree.ParseError as error:
        raise ValueError(f"urdf: XML expected, {error} found; check the file") from None
    if robot.tag != "robot":
        raise ValueError(f"urdf: a <robot> expected, <{robot.tag}> found; check the file")
    if any("xacro}" in element.tag for element in robot.iter()):
        raise ValueError("urdf: a URDF expected, xacro found; run `xacro FILE > robot.urdf`")
    _check_numbers(robot)
    joints = tuple(_joint(element) for element in robot.findall("joint"))
    _check_tree(joints, [link.get("name", "") for link in robot.findall("link")])
    return joints


def _joint(element: ElementTree.Element) -> UrdfJoint:
    name, kind = element.get("name", ""), element.get("type", "none")
    if kind in _REFUSED:
        raise ValueError(f"urdf: joint {name} is {kind}: {_REFUSED[kind]}")
    if kind not in (*_MOVABLE, "fixed"):
        raise ValueError(f"urdf: joint {name}: type {', '.join((*_MOVABLE, 'fixed'))} expected, {kind} found")
    parent, child, mimic = (
        {} if (part := element.find(tag)) is None else {key: "", **part.attrib}
        for tag, key in (("parent", "link"), ("child", "link"), ("mimic", "joint"))
    )
    multiplier, offset = float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0"))
    limits = None if kind in ("continuous", "fixed") else _limits(element.find("limit"))
    ends = parent.get("link", ""), child.get("link", "")
    return UrdfJoint(name, _MOVABLE.get(kind), *ends, mimic.get("joint"), multiplier, offset, limits)


def mimicked(known: Mapping[str, UrdfJoint], first: str, own: Collection[str]) -> tuple[str, float, float]:
    """Return the joint that the `first` one of those `known` mimics in the end, multiplier and offset [rad or m].

    own: joints that move by themselves, or stand, whatever they mimic.

    Raises:
        ValueError: it mimics itself, or a joint that is not known.
    """
    name, multiplier, offset, passed = first, 1.0, 0.0, set[str]()
    while name not in own and (joint := known[name]).type and joint.mimics is not None:
        passed.add(name)
        name, multiplier, offset = joint.mimics, multiplier * joint.multiplier, offset + multiplier * joint.offset
        if name not in known or name in passed:
            why = "round in a circle" if name in passed else f"to '{name}', which is none"
            raise ValueError(f"urdf: a <mimic> of a joint expected, but that of {first} leads {why}; correct it")
    return name, multiplier, offset


def _limits(element: ElementTree.Element | None) -> tuple[float, float] | None:
    """The limits that the `element` states; those that are no numbers, or leave no way, state none."""
    try:
        low, high = (
            (float(element.get(key, "0")) for key in ("lower", "upper")) if element is not None else (0.0, 0.0)
        )
    except ValueError:
        return None
    return (low, high) if low < high else None


def _check_tree(joints: tuple[UrdfJoint, ...], links: list[str]) -> None:
    """Raise ValueError unless `joints` connect all `links` to one root."""
    names = [*(f"joint {joint.name}" for joint in joints), *(f"link {link}" for link in links)]
    for name, count in Counter(names).items():
        if count > 1:
            raise ValueError(f"urdf: every joint and link once expected, {name} stands {count} times")
    for joint in joints:
        if missing := {joint.parent, joint.child} - set(links):
            raise ValueError(
                f"urdf: joint {joint.name}: <parent> and <child> among the links expected, '{min(missing)}' found"
            )
    moved = Counter(joint.child for joint in joints)
    if moved and max(moved.values()) > 1:
        raise ValueError(f"urdf: a tree expected, but link {moved.most_common(1)[0][0]} has two joints above it")
    roots = [link for link in links if link not in moved]
    if len(roots) != 1:
        raise ValueError(f"urdf: one link that no joint moves expected, {', '.join(roots) or 'none'} found")
    reached = set(roots)
    while further := {joint.child for joint in joints if joint.parent in reached} - reached:
        reached |= further
    if apart := set(links) - reached:
        raise ValueError(f"urdf: a tree expected, but the joints of link {min(apart)} lead round in a circle")


def _check_numbers(robot: ElementTree.Element) -> None:
    """Raise ValueError unless places, axes and inertial values are numbers, and complete."""
    for owner in (*robot.findall("joint"), *robot.findall("link")):
        name = f"{owner.tag} {owner.get('name', '')}"
        for part in owner.iter() if owner.tag == "joint" else owner.iterfind("inertial//"):
            for key, count in _NUMBERS.items():
                if (text := part.get(key)) is not None and not _holds(text, count):
                    raise ValueError(f"urdf: {name}: <{part.tag} {key}> of {count} numbers expected, '{text}' found")
        for inertial in owner.iterfind("inertial"):
            for tag, keys in _INERTIAL.items():
                if (held := inertial.find(tag)) is None or not set(keys) <= set(held.keys()):
                    raise ValueError(f"urdf: {name}: <{tag} {' '.join(keys)}> of <inertial> expected, not all found")
        if (axis := owner.find("axis")) is not None and not any(map(float, axis.get("xyz", "").split())):
            raise ValueError(f"urdf: {name}: an <axis> with a direction expected, {axis.get('xyz')} found")


def _holds(text: str, count: int) -> bool:
    try:
        return len(numbers := [float(word) for word in text.split()]) == count and all(map(math.isfinite, numbers))
    except ValueError:
        return False
