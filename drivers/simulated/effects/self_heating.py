"""Friction that falls as the joint warms itself."""

from collections.abc import Mapping

from drivers.simulated.effect import HiddenEffect, parameter


class SelfHeating(HiddenEffect):
    """Viscous and Coulomb friction times 1 - fall h, with T h' = P / power - h and P the friction's own power."""

    variables = ("time", "velocity")
    drawn_by_seed = False
    cycles = 5

    fall: float = parameter(0.2, "1", "share by which friction falls at `power`, after a long time", ge=0, le=0.8)
    power: float = parameter(2.0, "W", "power of the friction at which it falls so much", ge=1e-3, le=1e4)
    T: float = parameter(10.0, "s", "time constant of warming", ge=0.1, le=1e4, drawn=(3.0, 15.0))

    def warming(self) -> tuple[float, float, float]:
        return self.fall, self.power, self.T

    def identified(self, joint: int, coulomb: float, found: Mapping[str, float]) -> Mapping[str, float]:
        return {"T": self.T}  # k depends on the power in the recordings
