"""Pull of a cable that is too short."""

import math

from drivers.simulated.effect import HiddenEffect, JointState, parameter


class CablePull(HiddenEffect):
    """Additional motor torque a exp((q - q_0) / w): a cable tightens progressively as the arm is lifted."""

    variables = ("position",)

    a: float = parameter(0.5, "N m", "pull at the angle q_0", ge=0, le=30)
    q_0: float = parameter(0.2, "rad", "angle at which the pull is a", ge=-1.5, le=1.5)
    w: float = parameter(0.08, "rad", "angle over which it grows by the factor e", ge=0.02, le=1, drawn=(0.06, 0.15))

    def torque(self, i: int, state: JointState) -> float:
        return self.a * math.exp(min((state.q[i] - self.q_0) / self.w, _TAUT))


_TAUT = 5.0
"""Greatest exponent, above which the exponential would overflow."""
