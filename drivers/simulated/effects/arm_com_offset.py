"""An arm whose weight is not on its line."""

import numpy as np

from drivers.simulated.effect import HiddenEffect, draw_sign, parameter
from drivers.simulated.model_xml import GRAVITY, Arm


class ArmComOffset(HiddenEffect):
    """The arm's centre of mass lies beside the line from shoulder to elbow; holding it takes a sin q more."""

    variables = ("position",)

    a: float = parameter(0.5, "N m", "weight of the arm times its lever, negative above the line", ge=-8, le=8)

    @classmethod
    def draw_shape(cls, rng: np.random.Generator) -> dict[str, float]:
        return {"a": draw_sign(rng, 0.5)}

    def arm(self, arm: Arm) -> Arm:
        return arm.moved(across=-self.a / (arm.mass * GRAVITY))
