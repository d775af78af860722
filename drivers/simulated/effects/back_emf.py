"""The voltage that the turning motor itself makes."""

from drivers.simulated.effect import HiddenEffect, parameter


class BackEmf(HiddenEffect):
    """The reported voltage contains k_e v beyond what the torque takes."""

    variables = ("velocity", "load")

    k_e: float = parameter(0.05, "V s/rad", "voltage per speed of the joint", ge=0, le=2)

    def back_emf(self) -> float:
        return self.k_e
