"""A mechanism in a motion: the columns of its parameters, and what effects are computed from."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ident.basics.recent import RecentResults
from ident.dynamics.effect_inputs import EffectInputs, Masses
from ident.dynamics.mechanisms import Mechanism
from ident.dynamics.mechanisms.urdf import Urdf
from ident.dynamics.motion import Motion
from ident.dynamics.platform import platform
from recordings.recording import Floats
from recordings.rig import Rig
from recordings.urdf import Vector

_REMEMBERED = 3
"""Number of torques that are kept for each motion."""
_LARGEST = 1 << 24
"""Numbers in the columns of links beyond which these are not kept: 128 MB."""


@dataclass(frozen=True, eq=False)
class MechanismMotion:
    """A mechanism of `rig` in a motion of n instants, after correction of encoder and geometry errors."""

    rig: Rig
    motion: Motion
    mechanism: Mechanism
    beyond: tuple[tuple[float, Vector], ...] = ()
    """Masses [kg], NaN for an unknown one, and their places [m] beyond the payload that the parameters include."""

    recorded: bool = False
    """Whether this is the motion as it was recorded, along which many models are computed."""

    @cached_property
    def regressor(self) -> Floats:
        """(n, dof, k) columns of the mechanism's own parameters."""
        return self.mechanism.regressor(self.motion)

    def torque(self, parameters: Floats) -> Floats:
        """(n, dof) torque of the mechanism with the `parameters` (k,); not to be changed."""

        def compute() -> Floats:
            if isinstance(self.mechanism, Urdf) and self._columns_cost_more:
                return self.mechanism.torque(self.motion, parameters)
            return np.einsum("njk,k->nj", self.regressor, parameters)  # `@` goes instant by instant

        return self._torques.get(parameters.tobytes(), compute)

    @property
    def _columns_cost_more(self) -> bool:
        """Whether the torque of links is sooner known without columns, or these are too large."""
        return not self.recorded or self.motion.position.size * len(self.mechanism.parameters) > _LARGEST

    @cached_property
    def _torques(self) -> RecentResults:
        """Few: many effects need the same, beside one model after the other."""
        return RecentResults(_REMEMBERED)

    def effect_inputs(
        self,
        rate: float,
        time: Floats,
        bandwidth: float,
        load_parameters: Floats,
        temperature: Floats | None = None,
        end: float | None = None,
        arm_load_at: Callable[[EffectInputs], Floats] | None = None,
        unknown_payload: Masses = (),
    ) -> EffectInputs:
        """Inputs of effects.

        rate: instants per second [Hz]. time: (n,) [s]. bandwidth: of the analysis [Hz].
        load_parameters: (k or k + 1,) of mechanism and rods. temperature: (n, dof) of the drives [degC].
        end: time at which the run ends [s]; None: with the last instant.
        arm_load_at, unknown_payload: as in the inputs.
        """
        known = self.mechanism.parameters
        parameters, m_d = load_parameters[: len(known)], float(load_parameters[len(known) :].sum())
        rigid_parameters = np.where([parameter.friction for parameter in known], 0.0, parameters)

        def rigid_at(motion: Motion) -> Floats:
            moved = self if motion is self.motion else replace(self, motion=motion, recorded=False)
            torque = moved.torque(rigid_parameters)
            return torque + m_d * platform(self.rig.geometry, motion).torque_of_rods if m_d else torque

        by_name = {parameter.name: float(x) for parameter, x in zip(known, parameters, strict=True)}
        unknown = np.full_like(self.motion.position, np.nan)
        return EffectInputs(
            self.rig,
            rate,
            time,
            self.motion,
            rigid_at,
            bandwidth,
            {**by_name, "m_d": m_d},
            unknown if temperature is None else temperature,
            end,
            arm_load_at,
            self.beyond,
            unknown_payload,
        )
