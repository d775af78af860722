"""What an effect may look at: the motion, and what the rigid model makes of it. Nothing here is made from the
measured torque: a regressor that was would lower the error and explain nothing.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from ident.motion import Motion
from recordings.recording import Floats
from recordings.rig import Rig
from trajectories import kinematics

GRAVITY = 9.81
"""[m/s^2], downwards."""


@dataclass(frozen=True, eq=False)
class Platform:
    """The moving platform of a delta robot at n instants."""

    position: Floats
    """(n, 3) [m]."""
    velocity: Floats
    """(n, 3) [m/s]."""
    acceleration: Floats
    """(n, 3) [m/s^2]."""
    jacobian: Floats
    """(n, 3, 3) platform velocity per joint velocity, Eq. (16); a force F there takes J' F at the joints."""


@dataclass(frozen=True, eq=False)
class View:
    """n consecutive instants of dof joints at an even rate. NaN where something is not known."""

    rig: Rig
    rate: float
    """Instants per second [Hz]."""
    time: Floats
    """(n,) since the recording's first sample [s]."""
    motion: Motion
    """(n, dof) of the joints."""
    rigid_at: Callable[[Motion], Floats]
    """(n, dof) torque [N m] of the model without any friction, at that or another motion."""
    parameters: Mapping[str, float]
    """Of the mechanism's own parameters by name, as the model has them now."""

    @cached_property
    def rigid(self) -> Floats:
        """(n, dof) torque of the model without any friction [N m]."""
        return self.rigid_at(self.motion)

    @cached_property
    def platform(self) -> Platform:
        """The platform of a delta robot, Appendix A, Eqs. (16) and (23)."""
        return platform(self.rig, self.motion)

    def motor_inertia(self, share: float) -> Floats:
        """(dof,) of what turns with the encoder, as a `share` of each joint's own inertia [kg m^2]."""
        dof = self.motion.position.shape[1]
        own = (self.parameters.get(f"I_{j}", self.parameters.get(f"m_{j}", 0.0)) for j in range(1, dof + 1))
        return np.array([share * max(inertia, 0.0) for inertia in own])

    @cached_property
    def inertias(self) -> Floats:
        """(n, dof, dof) torque per acceleration [kg m^2]."""
        still = replace(self.motion, acceleration=np.zeros_like(self.motion.position))
        base = self.rigid_at(still)
        units = np.eye(base.shape[1])
        columns = [self.rigid_at(replace(still, acceleration=still.acceleration + unit)) - base for unit in units]
        return np.stack(columns, axis=2)

    def arm_inertias(self, share: float) -> Floats:
        """(n, dof, dof) `inertias` without the motors; on the diagonal a hundredth of it at least."""
        matrix = self.inertias.copy()
        whole = np.diagonal(self.inertias, axis1=1, axis2=2)
        joint = np.arange(whole.shape[1])
        matrix[:, joint, joint] = np.maximum(whole - self.motor_inertia(share), 0.01 * whole)
        return matrix

    def arm_torque(self, motion: Motion, share: float) -> Floats:
        """(n, dof) torque [N m] that moves all but the motors themselves, at a motion."""
        torque: Floats = self.rigid_at(motion) - self.motor_inertia(share) * motion.acceleration
        return torque

    def moved(self, by: Floats) -> Motion:
        """The motion with its angles changed by `by` (n, dof), its rates as they are."""
        return replace(self.motion, position=self.motion.position + by)

    def every(self, step: int) -> "View":
        """One of `step` instants."""
        motion = Motion(**{field.name: getattr(self.motion, field.name)[::step] for field in fields(Motion)})
        return replace(self, rate=self.rate / step, time=self.time[::step], motion=motion)


def platform(rig: Rig, motion: Motion) -> Platform:
    """The platform of the delta robot `rig` when its joints do `motion`."""
    geometry, theta, theta_dot = rig.geometry, motion.position, motion.velocity
    P = kinematics.forward(geometry, theta)
    J = kinematics.jacobian(geometry, theta, P)
    J_dot = kinematics.jacobian_derivative(geometry, theta, P, theta_dot, J)
    acceleration: Floats = np.einsum("nij,nj->ni", J, motion.acceleration) + np.einsum("nij,nj->ni", J_dot, theta_dot)
    return Platform(P, np.einsum("nij,nj->ni", J, theta_dot), acceleration, J)
