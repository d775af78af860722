"""Friction that follows a power of the speed."""

import math

from drivers.simulated.effect import HiddenEffect, JointState, parameter


class PowerLawFriction(HiddenEffect):
    """Grease that thins under shear: friction c |v|^alpha takes the place of viscous friction."""

    variables = ("velocity",)
    drawn_by_seed = False

    c: float = parameter(1.0, "N m (s/rad)^alpha", "friction at 1 rad/s", ge=0, le=30)
    alpha: float = parameter(0.5, "1", "power of the speed", ge=0.2, le=2, drawn=(0.3, 0.75))

    def friction(self, i: int, state: JointState) -> float:
        return self.c * math.pow(abs(state.v[i]), self.alpha)

    def viscous_share(self) -> float:
        return 0.0 if self.c else 1.0
