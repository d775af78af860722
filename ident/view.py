"""What an effect may look at: the motion, and what the rigid model makes of it. Nothing here is made from the measured
torque: a regressor that was would lower the error and explain nothing.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
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
    """(n, 3, 3) platform velocity per joint velocity, Eq. (16): a force F on the platform takes J' F of the joints."""


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

    def at(self, motion: Motion) -> "View":
        """The same with another motion."""
        return replace(self, motion=motion)


def platform(rig: Rig, motion: Motion) -> Platform:
    """The platform of the delta robot `rig` when its joints do `motion`."""
    geometry, theta, theta_dot = rig.geometry, motion.position, motion.velocity
    P = kinematics.forward(geometry, theta)
    J = kinematics.jacobian(geometry, theta, P)
    J_dot = kinematics.jacobian_derivative(geometry, theta, P, theta_dot, J)
    acceleration: Floats = np.einsum("nij,nj->ni", J, motion.acceleration) + np.einsum("nij,nj->ni", J_dot, theta_dot)
    return Platform(P, np.einsum("nij,nj->ni", J, theta_dot), acceleration, J)
