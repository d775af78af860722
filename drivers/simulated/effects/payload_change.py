"""A payload that is picked up during the run, and possibly put down."""

from typing import Self

from drivers.simulated.effect import HiddenEffect, parameter


class PayloadChange(HiddenEffect):
    """The platform's mass is higher by dm from the time t_c to t_e; the payload has the platform's velocity."""

    variables = ("time", "position", "acceleration")
    whole_robot = True

    dm: float = parameter(0.2, "kg", "mass of the payload", ge=0, le=3)
    t_c: float = parameter(5.0, "s", "time of picking up, on the machine's clock", ge=0, le=1e6, drawn=(7.0, 17.0))
    t_e: float = parameter(1e6, "s", "time of putting down", ge=0, le=1e6)

    def at(self, t: float) -> Self:
        return self.model_copy(update={"t_c": t, "t_e": 1e6})

    def added_mass(self, t: float) -> float:
        return self.dm if self.t_c <= t < self.t_e else 0.0
