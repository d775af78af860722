"""Inputs of effects: the motion and the torque of the rigid model.

Nothing here is derived from the measured torque: such a regressor would lower the error and explain nothing.
"""

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from ident.basics import filters, slicing
from ident.basics.recent import RecentResults
from ident.dynamics import mechanisms
from ident.dynamics.flexible_joints import FlexibleJoints, LinearArms
from ident.dynamics.motion import Motion
from ident.dynamics.platform import Platform, kernel_constants, platform
from recordings.recording import Floats
from recordings.rig import Rig
from recordings.urdf import Vector

_REMEMBERED = 8
"""Number of results that `EffectInputs.remembered` keeps."""
_PER_PERIOD = 4
"""Number of derivatives of the arms' torque in a period of the bandwidth."""
_LINEAR = 3
"""Number of `LinearArms` that are kept, for different compliances."""
_ROUNDED = 2
"""Number of compliances in an octave about whose static lag arms are linear."""
_TINY = 1e-30
"""Added to a compliance [rad/(N m)] to have a logarithm."""
_SMOOTH = ("position", "velocity", "acceleration")
"""Signals of a motion to which a low-pass may be applied."""


@dataclass(frozen=True, eq=False)
class EffectInputs:
    """Inputs of effects at n consecutive, evenly spaced instants of dof joints; NaN where unknown."""

    rig: Rig
    rate: float
    """Instants per second [Hz]."""
    time: Floats
    """(n,) since the recording's first sample [s]."""
    motion: Motion
    """Of the joints, (n, dof) each."""
    rigid_at: Callable[[Motion], Floats]
    """Computes the torque (n, dof) [N m] of the model without friction for this or another motion."""
    bandwidth: float
    """Bandwidth of the analysis [Hz]."""
    parameters: Mapping[str, float]
    """Present parameters of the mechanism by name; m_d: mass of uniform rods, 0 without."""
    temperature: Floats
    """(n, dof) of the drives [degC]."""
    end: float | None = None
    """Time at which the run ends [s]; None: with these instants."""
    arm_load_at: Callable[["EffectInputs"], Floats] | None = None
    """Computes the torque (n, dof) [N m] of the model's effects on the arms for these or other inputs; None: 0."""
    beyond: tuple[tuple[float, Vector], ...] = ()
    """Masses [kg], NaN for an unknown one, and their places [m] beyond the payload that the parameters include."""

    @cached_property
    def rigid(self) -> Floats:
        """Torque (n, dof) of the model without friction [N m]."""
        return self.rigid_at(self.motion)

    @cached_property
    def load(self) -> Floats:
        """Torque (n, dof) that the gears transmit, without friction: with that of the effects on the arms [N m]."""
        return self.rigid if self._arm_load is None else self.rigid + self._arm_load

    @cached_property
    def platform(self) -> Platform:
        """Motion of the platform of a delta robot, Appendix A, Eqs. (16) and (23)."""
        return platform(self.rig.geometry, self.motion)

    @cached_property
    def balls(self) -> Floats:
        """(2, n, 3) torque of unit dry and of unit viscous friction in the balls of a delta robot's rods."""
        from ident.dynamics.arm_kernels import balls_along  # numba takes time to load

        signals = map(np.ascontiguousarray, (self.motion.position, self.motion.velocity))
        return balls_along(kernel_constants(self.rig.geometry), *signals)

    @cached_property
    def torque_per_mass(self) -> Floats:
        """(n, dof) torque that moves and holds 1 kg where the payload is [N m/kg]."""
        place = self.rig.payload.com if self.rig.payload else (0.0, 0.0, 0.0)
        return mechanisms.create(self.rig).torque_per_mass(self.motion, place)

    @cached_property
    def low_passed(self) -> "EffectInputs":
        """The inputs with the motion low-passed at the bandwidth of the analysis, where the filter has an output.

        It has less quantisation noise of the encoders. A spring amplifies noise at its resonance, and with backlash
        an arm separates too early.
        """
        if self.bandwidth >= self.rate / 4:
            return self
        return replace(self, motion=_low_passed(self.motion, self.bandwidth, self.rate))

    def remembered(self, key: Hashable, compute: Callable[[], Floats]) -> Floats:
        """Return the result of `compute`, or the one of an earlier call with this `key`.

        The torque of flexible joints is needed several times with the same parameters: for each derivative with
        respect to another parameter, for example. Only the last few results are kept.
        """
        return self._results.get(key, compute)

    @cached_property
    def _results(self) -> RecentResults:
        return RecentResults(_REMEMBERED)

    @cached_property
    def joint_inertia(self) -> Floats:
        """Own inertia (dof,) of each joint, of which the motor has a share [kg m^2 or kg]; 0 where it is negative.

        It is the smallest one along the motion with the other joints at rest, so that any share leaves something to
        the arm; of a delta robot, whose platform loads all joints, that of arm and motor alone.
        """
        if self.rig.mechanism == "delta":
            return np.array([max(self.parameters[f"I_{joint}"], 0.0) for joint in (1, 2, 3)])
        return self._linear_arms.smallest_inertia

    def flexible_joints(
        self, share: float, smoothing: float = 1.0, compliance: Floats | None = None
    ) -> FlexibleJoints:
        """Return the arms without the motors, whose inertia is a `share` of each joint's own.

        smoothing: share of the motion above the bandwidth of the analysis that is taken out, 0 to 1.
        compliance: (dof,) of springs whose static lag is so large that the arms are not linear about the motors.
        """
        motors, smooth = share * self.joint_inertia, self.low_passed
        raw, low = (each.load - motors * each.motion.acceleration for each in (self, smooth))
        torque = low if smoothing == 1 else raw + smoothing * (low - raw)
        near = self._linear_arms
        if compliance is not None:
            # Rounded: a search with small steps needs few of them.
            rough = np.where(compliance > 0, 2 ** (np.round(_ROUNDED * np.log2(compliance + _TINY)) / _ROUNDED), 0.0)
            near = self._linear.get(rough.tobytes(), lambda: self._linear_arms.lagging(rough))
        return FlexibleJoints(torque, motors, near, self.rate)

    @cached_property
    def _linear(self) -> RecentResults:
        return RecentResults(_LINEAR)

    @cached_property
    def _linear_arms(self) -> LinearArms:
        """Torque of the arms near the low-passed motion, often enough for its bandwidth."""
        step = max(1, int(self.rate / (_PER_PERIOD * self.bandwidth)))
        return LinearArms.along(self.low_passed.motion, self.rigid_at, step)

    @cached_property
    def _arm_load(self) -> Floats | None:
        of_effects = None if self.arm_load_at is None else self.arm_load_at(self)
        if not self.beyond:
            return of_effects
        return self.torque_beyond if of_effects is None else of_effects + self.torque_beyond

    @cached_property
    def torque_beyond(self) -> Floats:
        """(n, dof) torque of the known masses `beyond` [N m]."""
        return mechanisms.torque_of_masses(mechanisms.create(self.rig), self.beyond, self.motion)

    def decimated(self, step: int) -> "EffectInputs":
        """Return every `step`-th instant."""
        return replace(slicing.along_time(self, slice(None, None, step)), rate=self.rate / step)


@lru_cache(maxsize=8)
def _low_passed(motion: Motion, bandwidth: float, rate: float) -> Motion:
    """Low-pass a `motion`, which stays the same while the parameters of the model change."""
    taps = filters.low_pass(bandwidth, rate)
    smooth = {name: filters.convolve(getattr(motion, name), taps) for name in _SMOOTH}
    known: dict[str, Any] = {name: np.where(np.isfinite(x), x, getattr(motion, name)) for name, x in smooth.items()}
    return replace(motion, **known)


@dataclass(frozen=True, eq=False)
class WatchedInputs(EffectInputs):
    """Inputs that tell `watch` the name of each quantity before an effect reads it."""

    watch: Callable[[str], None] = lambda name: None

    @classmethod
    def of(cls, inputs: EffectInputs, watch: Callable[[str], None]) -> "WatchedInputs":
        """Let `watch` know what is read of the `inputs`."""
        return cls(**{each.name: getattr(inputs, each.name) for each in fields(EffectInputs)}, watch=watch)

    def __getattribute__(self, name: str) -> object:
        if name != "watch" and not name.startswith("__"):
            super().__getattribute__("watch")(name)
        return super().__getattribute__(name)
