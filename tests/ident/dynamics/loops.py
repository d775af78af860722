"""Mechanisms with closed loops as URDF: a delta robot, and planar four-bar linkages."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from recordings.rig import Geometry, Rig

GEOMETRY = Geometry()
ARM, LEVER, ROD, PLATFORM = 1.7, 0.11, 0.23, 0.6
"""Mass of an arm [kg] and where its centre is [m]; masses of a uniform rod and of the platform [kg]."""
INERTIA = (0.05, 0.06, 0.07)
"""Of the arms about their joints [kg m^2]."""


def link(
    name: str, mass: float = 0.0, centre: Sequence[float] = (0, 0, 0), moments: Sequence[float] = (0, 0, 0)
) -> str:
    held = " ".join(f'i{x}{x}="{value!r}"' for x, value in zip("xyz", moments, strict=True))
    inertial = (
        f'<inertial><mass value="{mass!r}"/><origin xyz="{text(centre)}"/>'
        f'<inertia {held} ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    return f'<link name="{name}">{inertial if mass else ""}</link>'


def joint(
    name: str,
    parent: str,
    child: str,
    axis: str,
    at: Sequence[float] = (0, 0, 0),
    turn: float = 0.0,
    kind: str = "revolute",
) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{text(at)}" rpy="{text((0, 0, turn))}"/><axis xyz="{axis}"/></joint>'
    )


def text(numbers: Sequence[float]) -> str:
    return " ".join(repr(float(number)) for number in numbers)


def delta_keys() -> dict[str, Any]:
    """A delta robot: the platform on three prismatic joints, one rod for each limb on a universal joint."""
    parts = [
        *map(link, ("base", "slide_x", "slide_y")), link("platform", PLATFORM, (0, 0, 0.01), (1e-3, 1e-3, 1e-3)),
        joint("x", "base", "slide_x", "1 0 0", (0, 0, -0.4), kind="prismatic"),
        joint("y", "slide_x", "slide_y", "0 1 0", kind="prismatic"),
        joint("z", "slide_y", "platform", "0 0 1", kind="prismatic"),
    ]  # fmt: skip
    loops, along, across = [], GEOMETRY.L2, ROD * GEOMETRY.L2**2 / 12
    for limb, (phi, inertia) in enumerate(zip(GEOMETRY.phi, INERTIA, strict=True), start=1):
        out, own = np.array([np.cos(phi), np.sin(phi), 0.0]), inertia - ARM * LEVER**2
        parts += [
            link(f"arm_{limb}", ARM, (LEVER, 0, 0), (1e-3, own, own)), link(f"cross_{limb}"),
            link(f"rod_{limb}", ROD, (0, 0, -along / 2), (across, across, 0.0)),
            joint(f"motor_{limb}", "base", f"arm_{limb}", "0 -1 0", GEOMETRY.R * out, phi),
            joint(f"swing_{limb}", f"arm_{limb}", f"cross_{limb}", "0 1 0", (GEOMETRY.L1, 0, 0)),
            joint(f"lean_{limb}", f"cross_{limb}", f"rod_{limb}", "1 0 0"),
        ]  # fmt: skip
        loops.append(
            {"a": f"rod_{limb}", "b": "platform", "point_a": (0, 0, -along), "point_b": tuple(GEOMETRY.r * out)}
        )
    joints = tuple(f"motor_{limb}" for limb in (1, 2, 3))
    return {"urdf": robot(parts), "joints": joints, "loops": tuple(loops), "tool": "platform"}


def four_bar_keys(rocker: float = 0.3, **keys: Any) -> dict[str, Any]:
    """A crank of 0.3 m, a coupler of 0.5 m with a mass, and a rocker, in the plane of x and z; 0.5 m between them.

    The crank is called as its joint, and the ground as Pinocchio calls its own.
    """
    parts = [
        *map(link, ("universe", "drive", "rocker")), link("coupler", 2.0, (0.25, 0, 0), (0.0, 0.0, 0.0)),
        joint("drive", "universe", "drive", "0 -1 0"), joint("elbow", "drive", "coupler", "0 -1 0", (0, 0, 0.3)),
        joint("pivot", "universe", "rocker", "0 -1 0", (0.5, 0, 0)),
    ]  # fmt: skip
    loop = {"a": "coupler", "b": "rocker", "point_a": (0.5, 0.0, 0.0), "point_b": (0.0, 0.0, rocker)}
    return {"urdf": robot(parts), "joints": ("drive",), "loops": (loop,), **keys}


def mimicking(urdf: str, **how: tuple[str, float, float]) -> str:
    """The `urdf` with joints that mimic others: by name whom, multiplier and offset."""
    for name, (other, multiplier, offset) in how.items():
        before, start, after = urdf.partition(f'<joint name="{name}"')
        element = f'<mimic joint="{other}" multiplier="{multiplier!r}" offset="{offset!r}"/></joint>'
        urdf = before + start + after.replace("</joint>", element, 1)
    return urdf


def robot(parts: Sequence[str]) -> str:
    return f'<robot name="r">{"".join(parts)}</robot>'


def rig(keys: dict[str, Any]) -> Rig:
    return Rig(name="r", mechanism="urdf", **keys)
