"""Delay of the torque after the voltage."""

from collections.abc import Mapping

from drivers.simulated.effect import HiddenEffect, parameter


class ActuationDelay(HiddenEffect):
    """The torque follows the reported voltage after a delay: v(t) = map^-1(torque(t + delay))."""

    variables = ("velocity", "acceleration")

    delay: float = parameter(0.001, "s", "delay from voltage to torque", ge=0, le=0.01)

    def lag(self) -> float:
        return self.delay

    def identified(self, joint: int, coulomb: float, found: Mapping[str, float]) -> Mapping[str, float]:
        return {"delta": self.delay}
