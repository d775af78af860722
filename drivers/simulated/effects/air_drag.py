"""Aerodynamic drag of the platform."""

from drivers.simulated.effect import HiddenEffect, parameter


class AirDrag(HiddenEffect):
    """Aerodynamic drag of the platform or a hose: a force that grows with the square of the platform's speed."""

    variables = ("velocity", "position")
    whole_robot = True

    c: float = parameter(0.3, "N s^2/m^2", "force per square of the platform's speed", ge=0, le=30)

    def drag(self, speed: float) -> float:
        return self.c * speed
