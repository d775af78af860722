"""A worn spot of the gear."""

import math

from drivers.simulated.effect import HiddenEffect, JointState, parameter


class WornSpot(HiddenEffect):
    """Friction is higher around an angle q_0: dry friction grows by a exp(-((q - q_0) / w)^2)."""

    variables = ("position", "velocity")

    a: float = parameter(1.0, "N m", "additional dry friction in the middle of the spot", ge=0, le=30)
    q_0: float = parameter(-0.2, "rad", "position of the spot", ge=-1.5, le=1.5, drawn=(-0.6, 0.1))
    w: float = parameter(0.1, "rad", "half of its width", ge=0.01, le=1, drawn=(0.06, 0.15))

    def friction(self, i: int, state: JointState) -> float:
        return self.a * math.exp(-(((state.q[i] - self.q_0) / self.w) ** 2))
