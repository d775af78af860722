"""Different exponent of the torque map."""

from drivers.simulated.effect import HiddenEffect, parameter


class TorqueMapExponent(HiddenEffect):
    """Torque is gain |volts|^p sgn volts (volts in V) with p differing from the rig's 2 (square) or 1 (linear)."""

    variables = ("load",)

    excess: float = parameter(0.1, "1", "p minus the rig's", ge=-0.8, le=0.8)

    def exponent(self) -> float:
        return self.excess
