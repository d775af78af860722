"""Dry friction that bends before it slides."""

import math


class Bristle:
    """Dahl's law: z' = v - |v| z / z_s; friction is its level times z / z_s. At rest it is a spring."""

    def __init__(self, reach: float) -> None:
        """`reach`: z_s [rad]."""
        self._reach = reach
        self._bend = 0.0

    def step(self, v: float, dt: float) -> float:
        """Share of the level that opposes motion, after `dt` [s] at the speed v [rad/s]; exact for constant speed."""
        end = math.copysign(1.0, v)
        self._bend = end + (self._bend - end) * math.exp(-abs(v) * dt / self._reach)
        return self._bend

    def relax(self) -> None:
        """Straight again."""
        self._bend = 0.0
