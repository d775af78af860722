"""Dead band of the amplifier."""

import math

from drivers.simulated.effect import HiddenEffect, parameter


class AmplifierDeadband(HiddenEffect):
    """Commands within +-width give no voltage, others are reduced by it. Visible only in a reported *command*."""

    variables = ("load",)

    width: float = parameter(0.1, "V", "half of the dead band", ge=0, le=3)

    def amplify(self, volts: float) -> float:
        return math.copysign(max(abs(volts) - self.width, 0.0), volts)
