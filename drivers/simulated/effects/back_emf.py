"""Back-EMF in the reported voltage."""

from drivers.simulated.effect import HiddenEffect, parameter


class BackEmf(HiddenEffect):
    """The reported voltage contains k_e v in addition to the voltage of the torque."""

    variables = ("velocity", "load")

    k_e: float = parameter(0.05, "V s/rad", "voltage per speed of the joint", ge=0, le=2)

    def back_emf(self) -> float:
        return self.k_e
