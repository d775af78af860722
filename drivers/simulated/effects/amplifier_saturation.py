"""Voltage saturation of the amplifier."""

from drivers.simulated.effect import HiddenEffect, parameter


class AmplifierSaturation(HiddenEffect):
    """The voltage u / (1 + |u inverse_level|^n)^(1/n) follows the command u up to a level; n is the knee's sharpness.

    Visible only in a reported *command*.
    """

    variables = ("load",)

    inverse_level: float = parameter(0.15, "1/V", "1 / highest voltage", ge=0, le=1.5)
    n: float = parameter(6.0, "1", "sharpness of the knee", ge=1, le=50, drawn=(4.0, 12.0))

    def amplify(self, volts: float) -> float:
        return float(volts / (1 + abs(volts * self.inverse_level) ** self.n) ** (1 / self.n))
