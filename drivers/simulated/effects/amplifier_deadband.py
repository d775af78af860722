"""An amplifier that does not answer to small commands."""

import math

from drivers.simulated.effect import HiddenEffect, parameter


class AmplifierDeadband(HiddenEffect):
    """Commands within +-width give no voltage, others that much less. It shows in a reported *command* only."""

    variables = ("load",)

    width: float = parameter(0.1, "V", "half of the dead band", ge=0, le=3)

    def amplify(self, volts: float) -> float:
        return math.copysign(max(abs(volts) - self.width, 0.0), volts)
