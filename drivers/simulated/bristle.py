"""Presliding friction: Dahl's bristle model."""

import math


class Bristle:
    """Dahl's law: z' = v - |v| z / z_s; friction is its level times z / z_s. At rest it is a spring."""

    def __init__(self, displacement: float) -> None:
        """`reach`: z_s [rad]."""
        self._displacement = displacement
        self._deflection = 0.0

    def step(self, v: float, dt: float) -> float:
        """Friction over its level after `dt` [s] at the speed v [rad/s], opposing v; exact for constant speed."""
        end = math.copysign(1.0, v)
        self._deflection = end + (self._deflection - end) * math.exp(-abs(v) * dt / self._displacement)
        return self._deflection

    def relax(self) -> None:
        """Remove the deflection."""
        self._deflection = 0.0
