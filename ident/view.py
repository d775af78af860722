"""What an effect may look at: the motion, and what the rigid model makes of it. Nothing here is made from the
measured torque: a regressor that was would lower the error and explain nothing.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Literal

import numpy as np

from ident.motion import Motion
from ident.platform import Platform, platform
from recordings.recording import Floats
from recordings.rig import Rig

Rate = Literal["position", "acceleration"]

GRAVITY = 9.81
"""[m/s^2], downwards."""


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
    slope: Callable[[Rate], Floats]
    """(n, dof, dof) derivative of that torque by the position or the acceleration of each joint."""
    parameters: Mapping[str, float]
    """Of the mechanism's own parameters by name, as the model has them now; m_d: of uniform forearms, 0 without."""

    @cached_property
    def rigid(self) -> Floats:
        """(n, dof) torque of the model without any friction [N m]."""
        return self.rigid_at(self.motion)

    @cached_property
    def platform(self) -> Platform:
        """The platform of a delta robot, Appendix A, Eqs. (16) and (23)."""
        return platform(self.rig.geometry, self.motion)

    def motor_inertia(self, share: float) -> Floats:
        """(dof,) of what turns with the encoder, as a `share` of each joint's own inertia [kg m^2]."""
        dof = self.motion.position.shape[1]
        own = (self.parameters.get(f"I_{j}", self.parameters.get(f"m_{j}", 0.0)) for j in range(1, dof + 1))
        return np.array([share * max(inertia, 0.0) for inertia in own])

    @cached_property
    def inertias(self) -> Floats:
        """(n, dof, dof) rigid torque per acceleration of each joint [kg m^2]."""
        return self.slope("acceleration")

    @cached_property
    def stiffness(self) -> Floats:
        """(n, dof, dof) rigid torque per angle of each joint, everything else as it is [N m/rad]."""
        return self.slope("position")

    def arm_inertias(self, share: float) -> Floats:
        """(n, dof, dof) `inertias` without the motors; on the diagonal a hundredth of it at least."""
        matrix = self.inertias.copy()
        whole = np.diagonal(self.inertias, axis1=1, axis2=2)
        joint = np.arange(whole.shape[1])
        matrix[:, joint, joint] = np.maximum(whole - self.motor_inertia(share), 0.01 * whole)
        return matrix

    def arm_torque(self, share: float) -> Floats:
        """(n, dof) torque [N m] that moves all but the motors themselves."""
        torque: Floats = self.rigid - self.motor_inertia(share) * self.motion.acceleration
        return torque

    def weight_shift(self, by: Floats) -> Floats:
        """(n, dof) change of the rigid torque when arms stand `by` (n, dof) beside where the motors are."""
        change: Floats = np.einsum("nij,nj->ni", self.stiffness, by)
        return change

    def every(self, step: int) -> "View":
        """One of `step` instants."""
        motion = Motion(**{field.name: getattr(self.motion, field.name)[::step] for field in fields(Motion)})
        return replace(self, rate=self.rate / step, time=self.time[::step], motion=motion)
