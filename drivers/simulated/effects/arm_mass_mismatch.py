"""One arm that is heavier than the others."""

import numpy as np

from drivers.simulated.effect import HiddenEffect, draw_joints, parameter
from drivers.simulated.model_xml import GRAVITY, Arm


class ArmMassMismatch(HiddenEffect):
    """Something is fastened to the arm at its centre of mass; holding it takes a cos q more, moving it too."""

    variables = ("position",)

    a: float = parameter(0.5, "N m", "its weight times its distance from the shoulder", ge=0, le=8)

    @classmethod
    def draw_joints(cls, rng: np.random.Generator) -> tuple[int, ...]:
        return draw_joints(rng, 1)

    def arm(self, arm: Arm) -> Arm:
        return arm.loaded(self.a / (GRAVITY * arm.com))
