"""Inputs of effects: the motion and the torque of the rigid model.

Nothing here is derived from the measured torque: such a regressor would lower the error and explain nothing.
"""

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from ident.basics import filters, slicing
from ident.basics.recent import RecentResults
from ident.dynamics import mechanisms
from ident.dynamics.flexible_joints import FlexibleJoints, flexible_joints, joint_inertia
from ident.dynamics.motion import Motion
from ident.dynamics.platform import Platform, kernel_constants, platform
from recordings.recording import Floats
from recordings.rig import Rig
from recordings.urdf import Vector

_REMEMBERED = 8
"""Number of results that `EffectInputs.remembered` keeps."""
_PER_PERIOD = 6
"""Instants per period of the bandwidth at which trees of links are simulated."""
Masses = tuple[tuple[float, Vector | tuple[()]], ...]
"""Masses [kg] and their places [m]; () for a place that is given elsewhere."""
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
    unknown_payload: Masses = ()
    """Mass [kg] that the model has for the unknown one of `beyond`, and its place [m]; () where `beyond` has that.

    Its torque is a part of `arm_load_at`.
    """

    @cached_property
    def rigid(self) -> Floats:
        """Torque (n, dof) of the model without friction [N m]."""
        return self.rigid_at(self.motion)

    @cached_property
    def load(self) -> Floats:
        """Torque (n, dof) that the gears transmit, without friction: with that of the effects on the arms [N m]."""
        load = self.rigid if self._load_of_effects is None else self.rigid + self._load_of_effects
        return load + self.torque_beyond if self.beyond else load

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
        place = self.rig.payload.place if self.rig.payload else (0.0, 0.0, 0.0)
        return mechanisms.create(self.rig).torque_per_mass(self.motion, place)

    def low_passed(self, share: float = 1.0) -> "EffectInputs":
        """Return the inputs with less quantisation noise of the encoders in the motion.

        A spring amplifies noise at its resonance, and with backlash an arm separates too early.

        share: 0 to 1, share removed of the motion above the bandwidth of the analysis.
        """
        if not share or self.bandwidth >= self.rate / 4:
            return self
        if share == 1:
            return self._low_passed
        pairs = {name: (getattr(self.motion, name), getattr(self._low_passed.motion, name)) for name in _SMOOTH}
        mixed: dict[str, Any] = {name: (1 - share) * x + share * smooth for name, (x, smooth) in pairs.items()}
        return replace(self, motion=replace(self.motion, **mixed))

    @cached_property
    def _low_passed(self) -> "EffectInputs":
        """With the motion low-passed at the bandwidth of the analysis; unchanged where the filter has no output."""
        taps = filters.low_pass(self.bandwidth, self.rate)
        smooth = {name: filters.convolve(getattr(self.motion, name), taps) for name in _SMOOTH}
        known: dict[str, Any] = {
            name: np.where(np.isfinite(x), x, getattr(self.motion, name)) for name, x in smooth.items()
        }
        return replace(self, motion=replace(self.motion, **known))

    def coarsely(self, compute: Callable[["EffectInputs"], Floats]) -> Floats:
        """Compute a torque (n, dof) along the low-passed motion, at no more instants than its bandwidth needs.

        compute: returns it for the inputs that it is given, without NaN. An instant of a tree of links costs
            microseconds; the others are interpolated.
        """
        step, instants = self._coarse_step, np.arange(len(self.time))
        computed = compute(self._coarse)
        return computed if step == 1 else np.asarray(CubicSpline(instants[::step], computed)(instants))

    @cached_property
    def _coarse(self) -> "EffectInputs":
        return self.low_passed().decimated(self._coarse_step)

    @property
    def _coarse_step(self) -> int:
        return max(1, int(self.rate / (_PER_PERIOD * self.bandwidth)))

    def remembered(self, key: Hashable, compute: Callable[[], Floats]) -> Floats:
        """Return the result of `compute`, or the one of an earlier call with this `key`.

        The torque of flexible joints is needed several times with the same parameters: for each derivative with
        respect to another parameter, for example. Only the last few results are kept.
        """
        return self._results.get(key, compute)

    @cached_property
    def _results(self) -> RecentResults:
        return RecentResults(_REMEMBERED)

    def motor_inertia(self, share: float) -> Floats:
        """Motor inertia (dof,) [kg m^2]: a `share` of each joint's own inertia."""
        return share * self._joint_inertia

    @cached_property
    def _joint_inertia(self) -> Floats:
        return joint_inertia(self.rig, self.parameters)

    def flexible_joints(self, share: float) -> FlexibleJoints:
        """Return the arms without the motors, whose inertia is a `share` of each joint's own.

        They carry the masses `beyond`; their further load is that along the `motion` of these inputs.
        """
        found = [
            (mass, place or known)
            for mass, place in self.unknown_payload
            for unknown, known in self.beyond
            if np.isnan(unknown)
        ]
        load, masses = self._load_of_effects, [*mechanisms.known_masses(self.beyond), *found]
        if found and load is not None:
            load = load - mechanisms.torque_of_masses(mechanisms.create(self.rig), found, self.motion)
        return flexible_joints(self.rig, self.parameters, share, self.rate, load, masses)

    @cached_property
    def _load_of_effects(self) -> Floats | None:
        return None if self.arm_load_at is None else self.arm_load_at(self)

    @cached_property
    def torque_beyond(self) -> Floats:
        """(n, dof) torque of the known masses `beyond` [N m]."""
        return mechanisms.torque_of_masses(mechanisms.create(self.rig), self.beyond, self.motion)

    def arm_torque(self, share: float) -> Floats:
        """Torque (n, dof) [N m] that moves the arms if they follow the motors."""
        return self._rigid_arm_torque - self.motor_inertia(share) * self.motion.acceleration

    @cached_property
    def _rigid_arm_torque(self) -> Floats:
        return self.flexible_joints(0.0).rigid_torque(self.motion)

    def decimated(self, step: int) -> "EffectInputs":
        """Return every `step`-th instant."""
        return replace(slicing.along_time(self, slice(None, None, step)), rate=self.rate / step)


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
