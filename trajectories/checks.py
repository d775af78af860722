"""Checking a trajectory against the limits of the rig file before anything moves."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Rig
from trajectories import kinematics
from trajectories.trajectory import Trajectory

SLOW, MOVE = "slow the motion down", "move the path"


class LimitExceeded(BadInput):
    """A trajectory violates a limit of the rig, `time` [s] after its start."""

    def __init__(self, message: str, time: float) -> None:
        super().__init__(message)
        self.time = time


@dataclass(frozen=True)
class _Bound:
    """One quantity and its allowed range."""

    quantity: str
    """Name of the quantity, with {joint} where the columns are joints."""
    values: Floats
    """(n, k) values of the quantity [unit]."""
    low: float
    high: float
    unit: str
    limit: str
    """Name of the limit in the rig file."""
    remedy: str

    @property
    def violated(self) -> NDArray[np.bool_]:
        """(n, k) True where the value is out of range; NaN counts as out of range."""
        return ~((self.values >= self.low) & (self.values <= self.high))

    @property
    def usage(self) -> Floats:
        """(n, k) fraction of the limit in use; above 1 beyond the limit."""
        if np.isinf(self.high):
            return self.low / np.maximum(self.values, 1e-6 * self.low)
        middle = (self.low + self.high) / 2 if self.low else 0.0  # a distance has no lower limit
        return np.abs(self.values - middle) / (self.high - middle)

    @property
    def first_violation(self) -> int:
        """First row out of range; undefined where there is none."""
        return int(np.argmax(self.violated.any(axis=1)))

    @property
    def expected(self) -> str:
        """Allowed range as text."""
        if self.low == -self.high:
            return f"within ±{self.high:g} {self.unit}"
        if np.isinf(self.high):
            return f"at least {self.low:g} {self.unit}".rstrip()
        return f"between {self.low:g} and {self.high:g} {self.unit}"


def check(trajectory: Trajectory, rig: Rig) -> None:
    """Check a trajectory against `rig.limits`: workspace, singularity, joint angle, speed, acceleration, torque.

    Raises:
        LimitExceeded: a limit is violated; the error names the first instant, the value and the remedy.
    """
    violated = [bound for bound in _bounds(trajectory, rig) if bound.violated.any()]
    if not violated:
        return
    bound = min(violated, key=lambda bound: bound.first_violation)
    row, column = bound.first_violation, int(np.argmax(bound.violated[bound.first_violation]))
    time, value = row / trajectory.rate, bound.values[row, column]
    raise LimitExceeded(
        f"{trajectory.name}, t = {time:.3f} s: {bound.quantity.format(joint=column + 1)} {bound.expected} expected, "
        f"{value:.4g} found; {bound.remedy} or change limits.{bound.limit} in the rig file",
        time,
    )


def usage(trajectory: Trajectory, rig: Rig) -> dict[str, Floats]:
    """Fraction (n,) of each limit in use at each instant, by the name in the rig file; 1 is the limit itself."""
    return {bound.limit: bound.usage.max(axis=1) for bound in _bounds(trajectory, rig)}


def torque_estimate(trajectory: Trajectory, rig: Rig) -> Floats:
    """Estimate the joint torque (n, 3) [N m] of a frictionless rigid robot with the masses of `rig.nominal`.

    Eq. (26) with `nominal_parameters`: Eqs. (1)-(2) count the forearms twice and omit the parallel-axis term.
    """
    theta, acceleration = trajectory.joint_position, trajectory.joint_acceleration
    _, _, P_ddot, J = kinematics.platform_motion(rig.geometry, theta, trajectory.joint_velocity, acceleration)
    m_p, T_g, inertia = nominal_parameters(rig)
    return (
        inertia * acceleration + T_g * np.cos(theta) + m_p * np.einsum("nji,nj->ni", J, P_ddot - kinematics.GRAVITY)
    )


def nominal_parameters(rig: Rig) -> tuple[float, float, float]:
    """m_p [kg], T_g [N m] and the inertia of each joint [kg m^2] in Eq. (26), from the masses of the rig file.

    Half of each forearm's mass is at its elbow and half on the platform; the inertia of the arm is about its joint.
    """
    nominal, arm = rig.nominal, rig.geometry.L1
    inertia = nominal.motor_inertia + nominal.I_L1 + nominal.m_a * nominal.L1c**2 + nominal.m_d / 2 * arm**2
    weight = -kinematics.GRAVITY[2] * (nominal.m_a * nominal.L1c + nominal.m_d / 2 * arm)
    return nominal.m_p + 3 * nominal.m_d / 2, float(weight), inertia


def _bounds(trajectory: Trajectory, rig: Rig) -> Iterator[_Bound]:
    limits, unit = rig.limits, rig.position_units[0]
    if rig.mechanism == "delta":
        yield from _platform_bounds(trajectory, rig)
    angle = "joint {joint} angle" if unit == "rad" else "position of joint {joint}"
    joint_limits = "joint_min or joint_max"
    yield _Bound(angle, trajectory.joint_position, limits.joint_min, limits.joint_max, unit, joint_limits, MOVE)
    speed, maximum = trajectory.joint_velocity, limits.speed
    yield _Bound("joint {joint} speed", speed, -maximum, maximum, f"{unit}/s", "speed", SLOW)
    acceleration, maximum = trajectory.joint_acceleration, limits.acceleration
    yield _Bound("joint {joint} acceleration", acceleration, -maximum, maximum, f"{unit}/s^2", "acceleration", SLOW)


def _platform_bounds(trajectory: Trajectory, rig: Rig) -> Iterator[_Bound]:
    limits, P = rig.limits, trajectory.platform
    radius = np.hypot(P[:, :1], P[:, 1:2])
    margin = kinematics.singularity_margin(rig.geometry, trajectory.joint_position, P)[:, None]
    torque = torque_estimate(trajectory, rig)
    yield _Bound("distance from the z axis", radius, 0, limits.workspace_radius, "m", "workspace_radius", MOVE)
    yield _Bound("platform height", P[:, 2:], *limits.workspace_z, "m", "workspace_z", MOVE)
    yield _Bound("singularity margin", margin, limits.singularity_margin, np.inf, "", "singularity_margin", MOVE)
    yield _Bound("estimated torque of joint {joint}", torque, -limits.torque, limits.torque, "N m", "torque", SLOW)
