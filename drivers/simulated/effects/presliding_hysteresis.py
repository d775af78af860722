"""Presliding hysteresis of dry friction."""

from collections.abc import Mapping

from drivers.simulated.effect import HiddenEffect, parameter


class PreslidingHysteresis(HiddenEffect):
    """Dahl's model: dry friction is its level times z / z_s, with z' = v - |v| z / z_s.

    At rest the deflected bristles act as a spring that holds the joint.
    """

    variables = ("position", "velocity")

    z_s: float = parameter(0.01, "rad", "displacement over which friction builds up", ge=0, le=0.5)

    def bristle(self) -> float:
        return self.z_s if self.z_s > _RIGID else 0.0

    def identified(self, joint: int, coulomb: float, found: Mapping[str, float]) -> Mapping[str, float]:
        return {"a": coulomb, "z_s": self.z_s}


_RIGID = 1e-6
"""Displacement below which the bristle's period is shorter than the plant's time step [rad]."""
