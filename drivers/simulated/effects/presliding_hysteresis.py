"""Dry friction that builds up as the joint starts to move."""

from drivers.simulated.effect import HiddenEffect, parameter


class PreslidingHysteresis(HiddenEffect):
    """Bristles bend before they slide (Dahl): dry friction is its level times z / z_s, z' = v - |v| z / z_s.

    At rest the bent bristles are a spring, which holds the joint.
    """

    variables = ("position", "velocity")

    z_s: float = parameter(0.01, "rad", "displacement over which friction builds up", ge=0, le=0.5)

    def bristle(self) -> float:
        return self.z_s if self.z_s > _RIGID else 0.0


_RIGID = 1e-6
"""A shorter bristle would swing faster than the plant's time steps [rad]."""
