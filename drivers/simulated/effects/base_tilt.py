"""Tilt of the base."""

import math
from collections.abc import Mapping

from drivers.simulated.effect import HiddenEffect, parameter
from drivers.simulated.model_xml import GRAVITY


class BaseTilt(HiddenEffect):
    """The base is tilted: in the robot's frame gravity has horizontal components g_x and g_y."""

    variables = ("position",)
    whole_robot = True

    angle: float = parameter(0.03, "rad", "angle between the base's normal and the vertical", ge=0, le=0.5)
    direction: float = parameter(
        0.6, "rad", "of horizontal gravity, from x towards y", ge=-math.pi, le=math.pi, drawn=(-math.pi, math.pi)
    )

    def tilt(self) -> tuple[float, float]:
        horizontal = GRAVITY * math.sin(self.angle)
        return horizontal * math.cos(self.direction), horizontal * math.sin(self.direction)

    def identified(self, joint: int, coulomb: float, found: Mapping[str, float]) -> Mapping[str, float]:
        return dict(zip(("g_x", "g_y"), self.tilt(), strict=True))
