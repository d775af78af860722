"""Stribeck friction."""

import math

from drivers.simulated.effect import HiddenEffect, JointState, parameter


class Stribeck(HiddenEffect):
    """Static friction exceeds sliding friction: dry friction grows by a exp(-(v / v_s)^2)."""

    variables = ("velocity",)

    a: float = parameter(0.5, "N m", "static friction minus the Coulomb level", ge=0, le=8)
    v_s: float = parameter(0.3, "rad/s", "Stribeck velocity", ge=1e-3, le=3, drawn=(0.1, 0.5))

    def friction(self, i: int, state: JointState) -> float:
        return self.a * math.exp(-((state.v[i] / self.v_s) ** 2))
