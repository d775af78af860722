"""Drawn arms of six joints and their motions: torque by MuJoCo's inverse dynamics, base model by Pinocchio."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import mujoco
import numpy as np
import pinocchio
from scipy.interpolate import make_interp_spline

from benchmarks.flexible_arms import Coupling, arm_torque
from recordings.recording import Floats
from recordings.rig import Rig
from recordings.urdf import MotorCoupling

JOINTS, RATE = 6, 250.0
_RATIO = 0.8
"""Of the coupled wrist: the motor of joint 6 turns with joint 5, too."""
_AXES = {"roll": "1 0 0", "pitch": "0 1 0", "yaw": "0 0 1"}
_WRISTS = (("pitch", "yaw", "pitch"), ("roll", "pitch", "roll"))


@dataclass(frozen=True, eq=False)
class Way:
    """A motion (n, 6)."""

    time: Floats
    position: Floats
    velocity: Floats
    acceleration: Floats

    @classmethod
    def drawn(cls, rng: np.random.Generator, seconds: float) -> "Way":
        """Draw sums of sines that travel about two radians."""
        time, order = np.arange(0, seconds, 1 / RATE), np.array([1, 2, 3, 5, 8])[:, None]
        size = rng.normal(size=(5, JOINTS)) / order
        size *= rng.uniform(0.7, 1.2, JOINTS) / np.abs(size).sum(axis=0)
        omega, phase = 0.6 * order * rng.uniform(0.93, 1.07, (5, JOINTS)), rng.uniform(0, 2 * np.pi, (5, JOINTS))
        angle = omega * time[:, None, None] + phase
        parts = size * np.sin(angle), size * omega * np.cos(angle), -size * omega**2 * np.sin(angle)
        return cls(time, *(part.sum(axis=1) for part in parts))

    @classmethod
    def fast(cls, rng: np.random.Generator, seconds: float) -> "Way":
        """Draw sums of sines up to 2.5 Hz that travel about a radian, from rest: what shows springs and gaps."""
        time, order = np.arange(0, seconds, 1 / RATE), np.array([1, 2, 3, 5, 7, 9])[:, None]
        size = rng.normal(size=(6, JOINTS)) / order
        size *= rng.uniform(0.4, 0.6, JOINTS) / np.abs(size).sum(axis=0)
        omega, phase = 1.7 * order * rng.uniform(0.93, 1.07, (6, JOINTS)), rng.uniform(0, 2 * np.pi, (6, JOINTS))
        begun = np.clip(time / 1.5, 0, 1)[:, None]
        swell = begun**4 * (35 - 84 * begun + 70 * begun**2 - 20 * begun**3)
        path = make_interp_spline(time, swell * (size * np.sin(omega * time[:, None, None] + phase)).sum(axis=1), 5)
        return cls(time, *(path(time, nu=order) for order in range(3)))

    def read_as(self, position: Floats) -> "Way":
        """The same motion as other angles tell it."""
        velocity = np.gradient(position, 1 / RATE, axis=0)
        return Way(self.time, position, velocity, np.gradient(velocity, 1 / RATE, axis=0))


class Arm:
    """A drawn arm of six revolute joints, with friction and motors to suit.

    coupled: whether one motor turns with another joint, too.
    """

    def __init__(self, rng: np.random.Generator, coupled: bool = False) -> None:
        scale, wrist = float(rng.choice([0.6, 1.0, 1.6])), _WRISTS[rng.integers(2)]
        lengths = scale * np.array([0.0, 0.15, 0.45, 0.4, 0.1, 0.1])
        masses = scale**2 * np.array([8.0, 12.0, 6.0, 3.0, 2.0, 0.6]) * rng.uniform(0.7, 1.3, JOINTS)
        centres = scale * rng.uniform([0.05, -0.03, -0.03], [0.15, 0.03, 0.03], (JOINTS, 3))
        axes = [_AXES[name] for name in ("yaw", "pitch", "pitch", *wrist)]
        links = [
            (f"{length:.6f} 0 0", axis, " ".join(f"{x:.6f}" for x in centre), mass, mass * (0.1 * scale) ** 2)
            for length, axis, centre, mass in zip(lengths, axes, centres, masses, strict=True)
        ]
        self.urdf, self.mjcf = _urdf(links), _mjcf(links)
        couplings = (MotorCoupling(of=6, by=5, ratio=_RATIO),) * coupled
        joints = tuple(f"j{i + 1}" for i in range(JOINTS))
        self.rig = Rig(name="arm", mechanism="urdf", urdf=self.urdf, joints=joints, couplings=couplings)
        self.motors = np.eye(JOINTS)
        if coupled:
            self.motors[5, 4] = _RATIO
        self.motor = rng.uniform(0.3, 1.5, JOINTS) * masses * (0.2 * scale) ** 2
        size = np.sqrt(np.mean(self.rigid(Way.drawn(rng, 20.0)) ** 2, axis=0))
        self.coulomb, self.viscous = (rng.uniform(0.06, 0.2, JOINTS) * size for _ in range(2))

    def rigid(
        self, way: Way, gravity: Sequence[float] | Floats = (0.0, 0.0, -9.81), model: mujoco.MjModel | None = None
    ) -> Floats:
        """(n, 6) torque of links and motors along a motion; model: of other links."""
        model = model or mujoco.MjModel.from_xml_string(self.mjcf)
        model.opt.gravity[:], data, torque = gravity, mujoco.MjData(model), np.empty_like(way.position)
        for row, at in zip(torque, zip(way.position, way.velocity, way.acceleration, strict=True), strict=True):
            data.qpos[:], data.qvel[:], data.qacc[:] = at
            mujoco.mj_inverse(model, data)
            row[:] = data.qfrc_inverse
        return torque + self.motor * (way.acceleration @ self.motors.T) @ self.motors

    def behind(self, way: Way, joints: Sequence[int], make: Callable[[Floats], Coupling]) -> Floats:
        """(n, 6) torque of links behind springs or gaps on some `joints`, and of motors that move along `way`."""
        model = mujoco.MjModel.from_xml_string(self.mjcf)
        motion = way.position, way.velocity, way.acceleration
        return arm_torque(model, way.time, motion, joints, make) + self.motor * way.acceleration

    @cached_property
    def _robot(self) -> Any:
        return pinocchio.buildModelFromXML(self.urdf)

    def per_mass(self, way: Way) -> Floats:
        """(n, 6) torque of 1 kg at the origin of the last link."""
        return self._links(way)[:, :, 10 * (JOINTS - 1)]

    def regressor(self, way: Way) -> Floats:
        """(n, 6, K) of the base model: links, motors, viscous and Coulomb friction, offsets."""
        speed, offset = way.velocity @ self.motors.T, np.broadcast_to(np.eye(JOINTS), (len(way.time), JOINTS, JOINTS))
        motors = way.acceleration @ self.motors.T, speed, np.sign(speed)
        columns = (signal[:, None, :] * self.motors.T for signal in motors)
        return np.concatenate([self._links(way), *columns, offset], axis=2)

    def _links(self, way: Way) -> Floats:
        data, at = self._robot.createData(), zip(way.position, way.velocity, way.acceleration, strict=True)
        return np.array([pinocchio.computeJointTorqueRegressor(self._robot, data, *each).copy() for each in at])


def _urdf(links: Sequence[tuple[str, str, str, float, float]]) -> str:
    """The arm as the tool is told of it."""
    bodies = "".join(
        f'<link name="l{i}"><inertial><origin xyz="{centre}"/><mass value="{mass:.9f}"/><inertia ixx="{inertia:.9f}" '
        f'iyy="{inertia:.9f}" izz="{inertia:.9f}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        f'<joint name="j{i}" type="revolute"><parent link="l{i - 1}"/><child link="l{i}"/><origin xyz="{origin}"/>'
        f'<axis xyz="{axis}"/><limit lower="-3" upper="3" effort="1000" velocity="10"/></joint>'
        for i, (origin, axis, centre, mass, inertia) in enumerate(links, 1)
    )
    return f'<robot name="arm"><link name="l0"/>{bodies}</robot>'


def _mjcf(links: Sequence[tuple[str, str, str, float, float]]) -> str:
    """The same arm for MuJoCo."""
    opened = "".join(
        f'<body pos="{origin}"><joint axis="{axis}"/><inertial pos="{centre}" mass="{mass:.9f}" '
        f'diaginertia="{inertia:.9f} {inertia:.9f} {inertia:.9f}"/>'
        for origin, axis, centre, mass, inertia in links
    )
    return f"<mujoco><worldbody>{opened}{'</body>' * len(links)}</worldbody></mujoco>"
