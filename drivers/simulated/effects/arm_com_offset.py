"""Lateral offset of the arm's centre of mass."""

from dataclasses import replace

from drivers.simulated.effect import HiddenEffect, parameter
from drivers.simulated.model_xml import GRAVITY, Arm


class ArmComOffset(HiddenEffect):
    """The arm's centre of mass lies beside the line from shoulder to elbow; the holding torque is a sin q higher."""

    variables = ("position",)

    a: float = parameter(0.5, "N m", "weight of the arm times its lever arm, negative above the line", ge=-8, le=8)

    def arm(self, arm: Arm) -> Arm:
        return replace(arm, across=arm.across - self.a / (arm.mass * GRAVITY))
