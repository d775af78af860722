"""The plant: MuJoCo simulation of the robot, with static joint friction."""

import math
from collections.abc import Sequence

import mujoco
import numpy as np

from drivers.simulated.config import Links
from drivers.simulated.model_xml import GRAVITY, Arm, ShaftCoupling, model_xml
from recordings.recording import Floats
from recordings.rig import Geometry
from trajectories.kinematics import inverse

_CLOSURE_ROWS = 9
"""Rows of the three `connect` constraints; MuJoCo lists the friction of the joints right after them."""
_LEAST_FRICTION = 1e-9
"""Least friction [N m]; it keeps the friction row of every joint in that list."""
_SOFTNESS = 0.01
"""Softness of the friction constraint, relative to the least that MuJoCo offers."""
_SETTLING_TIME = 0.5
"""Time for elastic joints, critically damped meanwhile, to come to rest [s]."""
_ROLLING = 0.02
"""Angular velocity of a ball below which dry friction is less, so that it does not chatter [rad/s]."""
_OSCILLATING_INERTIA = 0.2
"""Approximate inertia that oscillates on elastic joints [kg m^2]."""


class Plant:
    """Three motors and the robot connected to them. Friction acts on the motor side of the couplings."""

    def __init__(
        self,
        geometry: Geometry,
        links: Links,
        arms: Sequence[Arm],
        couplings: Sequence[Sequence[ShaftCoupling]],
        *,
        viscous: Sequence[float],
        balls: tuple[float, float] = (0.0, 0.0),
        dt: float,
    ) -> None:
        """Arm, couplings and viscous friction [N m s/rad] of each limb; `dt`: time step [s].

        balls: dry [N m] and viscous [N m s/rad] friction at each end of the rods.
        """
        self.geometry = geometry
        self.elastic = any(couplings)
        """Whether a motor is not rigidly connected to its arm."""
        self.model = mujoco.MjModel.from_xml_string(model_xml(geometry, links, arms, couplings, dt))
        self.data = mujoco.MjData(self.model)
        self._platform_mass = links.platform_mass + links.payload
        self._motor = np.array([self.model.joint(f"motor_{i}").dofadr[0] for i in range(3)])
        self._slides = slice(self.model.nv - 3, self.model.nv)
        self.model.dof_damping[self._motor] = viscous
        # MuJoCo softens a friction constraint in proportion to this number; a soft one creeps under load.
        self.model.dof_invweight0[self._motor] *= _SOFTNESS
        # MuJoCo's arrays keep their addresses; fetching them in every step would cost more than using them.
        self._qpos, self._qvel, self._qacc = self.data.qpos, self.data.qvel, self.data.qacc
        self._applied, self._passive = self.data.qfrc_applied, self.data.qfrc_passive
        self._frictionloss = self.model.dof_frictionloss
        # Indexing by an array costs more than by three integers.
        self._motors: tuple[int, int, int] = tuple(self._motor.tolist())
        self._balls = balls
        self._rods = [self.model.body(f"rod_{i}").id for i in range(3)]
        self.set_friction((0.0, 0.0, 0.0))

    def place(self, platform: Sequence[float]) -> None:
        """Put the platform at a position [m], at rest, couplings relaxed, time zero.

        Raises:
            trajectories.kinematics.Unreachable: the platform cannot reach the position.
        """
        P = np.array(platform, dtype=np.float64)
        theta = inverse(self.geometry, P[None])[0]
        mujoco.mj_resetData(self.model, self.data)
        self._qpos[self._motor] = theta
        self._qpos[self._slides] = P
        for i in range(3):
            swing, sway = self._rod_angles(i, float(theta[i]), P)
            self.data.joint(f"swing_{i}").qpos = swing
            self.data.joint(f"sway_{i}").qpos = sway
        mujoco.mj_forward(self.model, self.data)

    def take_over(self, other: "Plant") -> None:
        """Go on where another plant stands; joints that it has not got are relaxed and at rest."""
        for number in range(other.model.njnt):
            name = other.model.joint(number).name
            try:
                joint = self.data.joint(name)
            except KeyError:
                continue
            joint.qpos, joint.qvel = other.data.joint(name).qpos, other.data.joint(name).qvel
        self._applied[self._slides] = other._applied[other._slides]
        mujoco.mj_forward(self.model, self.data)

    def step(self, torque: Sequence[float]) -> None:
        """One time step with the motor torques `torque` [N m]."""
        applied, (first, second, third) = self._applied, self._motors
        applied[first], applied[second], applied[third] = torque
        if any(self._balls):
            self._rub_balls()
        mujoco.mj_step(self.model, self.data)

    def _rub_balls(self) -> None:
        """Brake the rods relative to the platform, which only translates, and to the arms, which get the reaction.

        Balls let a rod spin about its axis as it likes: the model's spin neither rubs nor is braked.
        """
        dry, viscous = self._balls
        for rod in self._rods:
            arm, axis = self.model.body_parentid[rod], self.data.xmat[rod, ::3]
            of_rod, of_arm = self.data.cvel[rod, :3], self.data.cvel[arm, :3]
            turning = of_rod - axis * (axis @ of_rod)
            at_platform, at_arm = (
                (dry / math.hypot(*w, _ROLLING) + viscous) * w for w in (turning, turning - of_arm)
            )
            brake = at_platform + at_arm
            self.data.xfrc_applied[rod, 3:] = axis * (axis @ brake) - brake
            self.data.xfrc_applied[arm, 3:] = at_arm

    def settle(self) -> None:
        """Let elastic joints come to rest under the present friction, without torque."""
        damping = self.model.dof_damping.copy()
        self.model.dof_damping += 2 * np.sqrt(_OSCILLATING_INERTIA * self.model.jnt_stiffness)
        for _ in range(round(_SETTLING_TIME / self.model.opt.timestep)):
            self.step((0.0, 0.0, 0.0))
        self.model.dof_damping[:] = damping

    def motor_angles(self) -> list[float]:
        """Motor angles [rad]."""
        return self._of_motors(self._qpos)

    def motor_speeds(self) -> list[float]:
        """Motor speeds [rad/s]."""
        return self._of_motors(self._qvel)

    def motor_accelerations(self) -> list[float]:
        """Motor accelerations in the last step [rad/s^2]."""
        return self._of_motors(self._qacc)

    def _of_motors(self, joints: Floats) -> list[float]:
        values: list[float] = joints.tolist()
        first, second, third = self._motors
        return [values[first], values[second], values[third]]

    def platform(self) -> Floats:
        """(3,) position of the platform [m]."""
        return self._qpos[self._slides].copy()

    def platform_velocity(self) -> list[float]:
        """Velocity of the platform [m/s]."""
        return self._qvel[self._slides].tolist()

    def push(self, force: Sequence[float]) -> None:
        """Apply a force to the platform [N], from the next step on."""
        self._applied[self._slides] = force

    def set_friction(self, level: Sequence[float]) -> None:
        """Set static and sliding friction of each joint [N m]."""
        loss = self._frictionloss
        for motor, torque in zip(self._motors, level, strict=True):
            loss[motor] = torque if torque > _LEAST_FRICTION else _LEAST_FRICTION

    def rigid_torque(self) -> list[float]:
        """Torque transmitted to the rigid robot, after friction, in the last step, per joint [N m]."""
        applied, passive, dry = self._applied, self._passive, self.data.efc_force
        return [float(applied[j] + passive[j] + dry[_CLOSURE_ROWS + i]) for i, j in enumerate(self._motors)]

    def set_added_mass(self, mass: float) -> None:
        """Set the mass on the platform in addition to its own and the payload of the sim file [kg]."""
        total = self._platform_mass + mass
        self.model.body_mass[-1] = total
        # MuJoCo reads the inertia of the three slides from here.
        self.model.dof_M0[self._slides] = total

    def set_tilt(self, g_x: float, g_y: float) -> None:
        """Set the horizontal components of gravity [m/s^2]; its magnitude is unchanged."""
        self.model.opt.gravity = (g_x, g_y, -math.sqrt(GRAVITY**2 - g_x**2 - g_y**2))

    def _rod_angles(self, i: int, theta: float, P: Floats) -> tuple[float, float]:
        """Angles of the universal joint of rod i between elbow and platform [rad]."""
        geometry, phi = self.geometry, self.geometry.phi[i]
        x = P[0] * math.cos(phi) + P[1] * math.sin(phi) + geometry.r - geometry.R - geometry.L1 * math.cos(theta)
        y = P[1] * math.cos(phi) - P[0] * math.sin(phi)
        z = P[2] - geometry.L1 * math.sin(theta)
        return math.atan2(z, x) - theta, math.asin(y / geometry.L2)
