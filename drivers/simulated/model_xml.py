"""The robot as a MuJoCo model: a closed chain of three arms, three rods and a platform that only translates.

Each limb has its own frame, rotated by phi about z: x points outwards, the arm's hinge is along -y so that a
positive angle lifts the elbow. A universal joint connects the rod to the elbow, and a `connect` constraint between
two sites connects its tip to the platform.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

from drivers.simulated.config import Links
from recordings.rig import Geometry

GRAVITY = 9.81
"""[m/s^2]"""

# MuJoCo requires an inertia of every body; this one has no visible effect on the torque.
_SPIN_INERTIA = 1e-6


@dataclass(frozen=True)
class ShaftCoupling:
    """A torsional joint between the motor's shaft and the arm: backlash of +-`gap`, or a spring."""

    stiffness: float = 0.0
    """[N m/rad]; 0: no spring."""
    damping: float = 0.0
    """[N m s/rad]."""
    gap: float | None = None
    """Half of the backlash [rad]; None: not limited."""


@dataclass(frozen=True)
class Arm:
    """A rigid arm: mass [kg], centre of mass [m], and inertia about it [kg m^2]."""

    mass: float
    com: float
    """Distance of the centre of mass from the shoulder, along the line to the elbow."""
    inertia: float
    across: float = 0.0
    """Distance of the centre of mass from that line; positive is up while the arm is horizontal."""

    @classmethod
    def of(cls, links: Links) -> Self:
        """The arm of the sim file."""
        return cls(mass=links.arm_mass, com=links.arm_com, inertia=links.arm_inertia)


def model_xml(
    geometry: Geometry,
    links: Links,
    arms: Sequence[Arm],
    couplings: Sequence[Sequence[ShaftCoupling]],
    dt: float,
) -> str:
    """The MJCF text. Joints are named motor_i, twist_i_k, swing_i, sway_i (i from 0), x, y, z.

    Joint friction is omitted: the plant sets it.
    """
    limbs = "".join(_limb(i, geometry, links, arms[i], couplings[i], dt) for i in range(3))
    sites = "".join(f'<site name="platform_{i}" pos="{_xyz(geometry.r, geometry.phi[i])}"/>' for i in range(3))
    slides = "".join(
        f'<joint name="{name}" type="slide" axis="{axis}"/>'
        for name, axis in (("x", "1 0 0"), ("y", "0 1 0"), ("z", "0 0 1"))
    )
    connects = "".join(f'<connect site1="rod_{i}" site2="platform_{i}" {_stiffest("", dt)}/>' for i in range(3))
    mass = links.platform_mass + links.payload
    return f"""
<mujoco model="delta">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="{dt}" integrator="implicitfast" gravity="0 0 {-GRAVITY}" jacobian="dense" tolerance="1e-12">
    <flag contact="disable"/>
  </option>
  <worldbody>
    {limbs}
    <body name="platform">
      <inertial pos="0 0 0" mass="{mass}" diaginertia="0.01 0.01 0.01"/>
      {slides}
      {sites}
    </body>
  </worldbody>
  <equality>{connects}</equality>
</mujoco>"""


def _limb(i: int, geometry: Geometry, links: Links, arm: Arm, couplings: Sequence[ShaftCoupling], dt: float) -> str:
    """One limb: motor, couplings in series, arm, rod.

    n couplings connect n pieces of shaft, which share the motor's inertia, and the arm. Without couplings the
    motor's inertia is the armature of the arm's joint.
    """
    frame = f'pos="{_xyz(geometry.R, geometry.phi[i])}" euler="0 0 {geometry.phi[i]}"'
    armature = 0.0 if couplings else links.motor_inertia
    joints = [f'name="motor_{i}" armature="{armature}" {_stiffest("friction", dt)}']
    joints += [f'name="twist_{i}_{k}" {_coupling(coupling, dt)}' for k, coupling in enumerate(couplings)]
    share = links.motor_inertia / max(len(couplings), 1)
    text = f"""
<inertial pos="{arm.com} 0 {arm.across}" mass="{arm.mass}"
          diaginertia="{arm.inertia} {arm.inertia} {arm.inertia}"/>{_rod(i, geometry, links)}"""
    for number, joint in reversed(list(enumerate(joints))):
        if number < len(couplings):
            text = f'<inertial pos="0 0 0" mass="1e-3" diaginertia="{share} {share} {share}"/>{text}'
        place = frame if number == 0 else ""
        text = f'<body {place}><joint axis="0 -1 0" {joint}/>{text}</body>'
    return text


def _rod(i: int, geometry: Geometry, links: Links) -> str:
    """The rod, connected to the elbow."""
    across = links.rod_mass * geometry.L2**2 / 12
    return f"""
<body name="rod_{i}" pos="{geometry.L1} 0 0">
  <inertial pos="{geometry.L2 / 2} 0 0" mass="{links.rod_mass}" diaginertia="{_SPIN_INERTIA} {across} {across}"/>
  <joint name="swing_{i}" axis="0 -1 0"/>
  <joint name="sway_{i}" axis="0 0 1"/>
  <site name="rod_{i}" pos="{geometry.L2} 0 0"/>
</body>"""


def _coupling(coupling: ShaftCoupling, dt: float) -> str:
    gap = coupling.gap
    limit = "" if gap is None else f'range="{-gap} {gap}" {_stiffest("limit", dt)}'
    return f'stiffness="{coupling.stiffness}" damping="{coupling.damping}" {limit}'


def _stiffest(kind: str, dt: float) -> str:
    """The stiffest constraint of a kind that the time step allows: with softer friction a stuck joint creeps."""
    return f'solref{kind}="{2 * dt} 1" solimp{kind}="0.9999 0.9999 1"'


def _xyz(radius: float, angle: float) -> str:
    return f"{radius * math.cos(angle)} {radius * math.sin(angle)} 0"
