"""What an effect may look at: the motion, and what the rigid model makes of it. Nothing here is made from the
measured torque: a regressor that was would lower the error and explain nothing.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from ident import filters
from ident.dynamics.flexible_joints import FlexibleJoints, flexible_joints, joint_inertia
from ident.dynamics.motion import Motion
from ident.dynamics.platform import Platform, platform
from ident.dynamics.rods import GRAVITY as GRAVITY
from recordings.recording import Floats
from recordings.rig import Rig

_SMOOTH = ("position", "velocity", "acceleration")
"""Parts of a motion that a low-pass may calm."""


@dataclass(frozen=True, eq=False)
class EffectInputs:
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
    bandwidth: float
    """Of the analysis [Hz]."""
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

    def low_passed(self, share: float = 1.0) -> "EffectInputs":
        """With less of what encoder steps make of the motion: arms that swing or fly must not be shaken by it.

        A spring amplifies it where it swings, and an arm that waits for its load to change sides leaves too early.

        share: of what the motion has beyond the bandwidth of the analysis that is taken away, 0 to 1.
        """
        if not share or self.bandwidth >= self.rate / 4:
            return self
        if share == 1:
            return self._low_passed
        pairs = {name: (getattr(self.motion, name), getattr(self._low_passed.motion, name)) for name in _SMOOTH}
        between = {name: (1 - share) * x + share * calm for name, (x, calm) in pairs.items()}
        return replace(self, motion=replace(self.motion, **between))

    @cached_property
    def _low_passed(self) -> "EffectInputs":
        """With the motion within the bandwidth of the analysis; where that is not known, as it is."""
        taps = filters.low_pass(self.bandwidth, self.rate)
        smooth = {name: filters.convolve(getattr(self.motion, name), taps) for name in _SMOOTH}
        known = {name: np.where(np.isfinite(x), x, getattr(self.motion, name)) for name, x in smooth.items()}
        return replace(self, motion=replace(self.motion, **known))

    def motor_inertia(self, share: float) -> Floats:
        """(dof,) of what turns with the encoder, as a `share` of each joint's own inertia [kg m^2]."""
        return share * joint_inertia(self.parameters, self.motion.position.shape[1])

    def flexible_joints(self, share: float) -> FlexibleJoints:
        """All but the motors themselves, which are a `share` of each joint's own inertia."""
        return flexible_joints(self.rig, self.parameters, share, self.rate)

    def arm_torque(self, share: float) -> Floats:
        """(n, dof) torque [N m] that moves the arms, if they follow the motors."""
        torque: Floats = self._rigid_arm_torque - self.motor_inertia(share) * self.motion.acceleration
        return torque

    @cached_property
    def _rigid_arm_torque(self) -> Floats:
        return self.flexible_joints(0.0).rigid_torque(self.motion)

    def decimated(self, step: int) -> "EffectInputs":
        """One of `step` instants."""
        motion = Motion(**{field.name: getattr(self.motion, field.name)[::step] for field in fields(Motion)})
        return replace(self, rate=self.rate / step, time=self.time[::step], motion=motion)
