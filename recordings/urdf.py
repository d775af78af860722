"""The description of any robot: the joints of a URDF, and what of it a recording holds."""

import math
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Any, Literal, Self
from xml.etree import ElementTree

from pydantic import Field, Strict, WrapValidator, model_validator

from recordings.config import ConfigSection, Positive
from recordings.errors import BadInput
from recordings.limits import LARGEST_TEXT, bounded_content
from recordings.urdf_joints import JointType, UrdfJoint, mimicked, read_joints

Vector = tuple[float, float, float]


class MotorCoupling(ConfigSection):
    """A motor that turns with another joint, as in the wrists of many arms: at q'_of + ratio q'_by."""

    of: int
    """Joint that the motor drives, from 1; the motor's inertia and friction act on joint `by`, too."""
    by: int
    """Joint with which the motor turns as well, from 1."""
    ratio: float = 1.0
    """Turns of the motor, counted at joint `of`, per turn of joint `by`."""


class Loop(ConfigSection):
    """A point of one link that stays at a point of another, as a ball joint holds them together."""

    a: str
    """Name of a link of the URDF."""
    b: str
    """Name of the other link."""
    point_a: Vector = (0.0, 0.0, 0.0)
    """The point in the frame of `a` [m]."""
    point_b: Vector = (0.0, 0.0, 0.0)
    """The point in the frame of `b` [m]."""


class Payload(ConfigSection):
    """A load on the platform of a delta robot, or on what the last joint moves."""

    mass: Positive | Literal["unknown"]
    """[kg]. "unknown" makes it a parameter of a fit together with a recording of a known payload, or of none."""
    com: Annotated[Vector, Strict(False)] | Literal["unknown"] = (0.0, 0.0, 0.0)
    """Its centre of mass [m]: in the frame of the last link, or of the rig's `tool`; of an axis with x along the arm
    at angle zero and y along the axis. On a delta robot's platform, which does not turn, any place is the same.
    "unknown" makes it parameters, too, beside a mass that is "unknown"."""

    @classmethod
    def read(cls, content: Any, validate: Callable[[Any], Any]) -> Any:
        """Read `content` of a file; "unknown" alone stands for all of it."""
        return cls(mass="unknown", com="unknown") if content == "unknown" else validate(content)

    @property
    def known_mass(self) -> float:
        """[kg]; NaN where it is unknown."""
        return math.nan if self.mass == "unknown" else self.mass

    @property
    def place(self) -> Vector:
        """Its centre of mass [m]; NaN where it is unknown."""
        return (math.nan,) * 3 if self.com == "unknown" else self.com

    @model_validator(mode="after")
    def _check_place(self) -> Self:
        if self.com == "unknown" and self.mass != "unknown":
            raise ValueError('payload.com: three lengths [m] of a known mass expected, "unknown" found; give them')
        return self


class Chain(ConfigSection):
    """Keys of the mechanism "urdf": any tree of links, and loops that its joints close."""

    urdf: str = ""
    """The URDF: its path, relative to the rig file; a recording holds its text. Meshes are never opened."""
    joints: tuple[str, ...] = ()
    """Names of the joints that are driven, in the order of the recording's columns."""
    fixed: dict[str, float] = Field(default_factory=dict)
    """Positions of other movable joints, by name [rad or m]; 0 where none is given. Those within `loops`, or with a
    `<mimic>`, are fixed only if they stand here."""
    loops: tuple[Loop, ...] = ()
    """Points that stay together. Joints between them that are neither driven nor fixed follow the driven ones."""
    start: dict[str, float] = Field(default_factory=dict)
    """Near which positions the loops close, by joint [rad or m]; 0 where none is given. It tells on which side of a
    stretched pose the joints that follow are."""
    tool: str = ""
    """Link that carries a payload; none: the one that the last of `joints` moves."""
    gravity: Vector = (0.0, 0.0, -9.81)
    """Acceleration of gravity in the frame of the URDF's root [m/s^2]."""
    couplings: tuple[MotorCoupling, ...] = ()
    """Motors that turn with another joint."""
    motor_inertia: bool = True
    """Whether the inertia of each motor is a parameter of its own."""
    payload: Annotated[Payload | None, WrapValidator(Payload.read)] = None
    """What is mounted; "unknown" alone: neither mass nor centre is known. Identified parameters include it, and so
    does the reference model. Where recordings differ, they include that of the first one, and what the others have
    beyond it is known."""

    @property
    def chain(self) -> "Chain":
        """These keys alone."""
        return Chain.model_validate({name: getattr(self, name) for name in Chain.model_fields})

    @property
    def types(self) -> tuple[JointType, ...]:
        """Type of each of `joints`."""
        types = {joint.name: joint.type for joint in read_joints(self.urdf)}
        return tuple(kind for name in self.joints if (kind := types[name]) is not None)

    @property
    def properties(self) -> dict[str, Any]:
        """The keys by name, with the digest of the URDF in place of its text."""
        digest = f"sha256:{sha256(self.urdf.encode()).hexdigest()[:12]}" if self.urdf else "none"
        return {**{name: getattr(self, name) for name in Chain.model_fields}, "urdf": digest}

    @model_validator(mode="after")
    def _check_chain(self) -> Self:
        if self.urdf:
            self._check_joints({joint.name: joint for joint in read_joints(self.urdf)})
        return self

    @property
    def following(self) -> tuple[str, ...]:
        """Names of the joints that follow the driven ones, within loops or by `<mimic>`, in the order of the URDF."""
        if not self.loops:
            return tuple(name for name, (other, *_) in self.mimicking.items() if other in self.joints)
        above = {joint.child: joint for joint in read_joints(self.urdf)}

        def way(link: str) -> set[str]:
            return {above[link].name} | way(above[link].parent) if link in above else set()

        within = {name for loop in self.loops for name in way(loop.a) ^ way(loop.b)}
        others = (joint.name for joint in above.values() if joint.type and joint.name in within)
        return tuple(name for name in others if name not in (*self.joints, *self.fixed))

    @property
    def mimicking(self) -> dict[str, tuple[str, float, float]]:
        """Whom each joint with a `<mimic>` that is neither driven nor fixed repeats in the end, and how.

        Name of a joint: position = multiplier * that of the other one + offset [rad or m].

        Raises:
            ValueError: it repeats a joint that the URDF does not have, or itself.
        """
        known, own = {joint.name: joint for joint in read_joints(self.urdf)}, {*self.joints, *self.fixed}
        names = [joint.name for joint in known.values() if joint.type and joint.mimics is not None]
        return {name: mimicked(known, name, own) for name in names if name not in own}

    @property
    def standing(self) -> dict[str, float]:
        """Positions of the joints that stand, by name [rad or m]: of `fixed` ones, and of those that mimic them."""
        others = {name: how for name, how in self.mimicking.items() if name not in self.following}
        return self.fixed | {
            name: multiplier * self.fixed.get(other, 0.0) + offset
            for name, (other, multiplier, offset) in others.items()
        }

    def _check_joints(self, known: dict[str, UrdfJoint]) -> None:
        movable = ", ".join(name for name, joint in known.items() if joint.type)
        if not self.joints:
            raise ValueError(f"joints: names of the driven joints expected, none found; the URDF has {movable}")
        self._check_names(known, movable)
        if self.loops and not self.following:
            raise ValueError("loops: joints within them that are neither driven nor fixed expected, none found")
        self._check_mimicking(known)
        numbers = range(1, len(self.joints) + 1)
        for coupling in self.couplings:
            if coupling.of == coupling.by or not {coupling.of, coupling.by} <= set(numbers):
                raise ValueError(
                    f"couplings: two different joints from 1 to {len(self.joints)} expected, of = {coupling.of} and "
                    f"by = {coupling.by} found"
                )

    def _check_mimicking(self, known: dict[str, UrdfJoint]) -> None:
        """Raise ValueError if a driven joint mimics another one, or one that moves does beside loops."""
        for name in self.joints:
            if known[name].mimics is not None:
                raise ValueError(
                    f"joints: joints with motors of their own expected, but {name} mimics {known[name].mimics}; take "
                    f"{name} out of joints, for it follows, or remove <mimic> where it has a motor"
                )
        moving = {*self.joints, *self.following}
        for name, (other, *_) in self.mimicking.items():
            if self.loops and {name, other} & moving:
                raise ValueError(
                    f"loops: no moving joint that mimics another expected beside them, but {name} mimics {other}; "
                    f"remove <mimic> and let a loop hold {name}, or name it in fixed"
                )

    def _check_names(self, known: dict[str, UrdfJoint], movable: str) -> None:
        """Raise ValueError unless all joints and links that keys name are those of the URDF."""
        named = {"joints": self.joints, "fixed": self.fixed, "start": self.start}
        for key, name in ((key, name) for key, names in named.items() for name in names):
            if name not in known or known[name].type is None:
                found = "a fixed one" if name in known else "no joint of that name"
                raise ValueError(f"{key}: movable joints of the URDF expected ({movable}), '{name}' found, {found}")
            if self.joints.count(name) + (name in self.fixed) > 1:
                raise ValueError(f"{key}: every joint once in joints or fixed expected, '{name}' twice found")
        links = {link for joint in known.values() for link in (joint.parent, joint.child)}
        ends = [("loops", end) for loop in self.loops for end in (loop.a, loop.b)]
        for key, link in (*ends, *[("tool", self.tool)] * bool(self.tool)):
            if link not in links:
                raise ValueError(f"{key}: links of the URDF expected ({', '.join(sorted(links))}), '{link}' found")


def with_text(content: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Replace the path of a URDF in the `content` of a rig file in `folder` by the text of that file.

    Raises:
        BadInput: the file cannot be read.
    """
    if not isinstance(name := content.get("urdf"), str):
        return content
    return content | {"urdf": _text(folder / name)}


def _text(path: Path) -> str:
    what = "'urdf' of the rig file:"
    content = bounded_content(path, what, LARGEST_TEXT)
    try:
        if b"\0" not in content:  # as UTF-16 has
            return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        pass
    try:  # an XML parser knows other encodings, by the first bytes or by what these declare
        return ElementTree.tostring(ElementTree.fromstring(content), encoding="unicode")
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        raise BadInput(f"{what} {path}: XML in UTF-8 expected, {error} found; save it as UTF-8") from None
