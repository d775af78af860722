"""Additional mass on one arm."""

import numpy as np

from drivers.simulated.effect import HiddenEffect, draw_joints, parameter
from drivers.simulated.model_xml import GRAVITY, Arm


class ArmMassMismatch(HiddenEffect):
    """A mass at the arm's centre of mass; the holding torque is a cos q higher, the inertia grows as well."""

    variables = ("position",)

    a: float = parameter(0.5, "N m", "its weight times its distance from the shoulder", ge=0, le=8)

    @classmethod
    def draw_joints(cls, rng: np.random.Generator) -> tuple[int, ...]:
        return draw_joints(rng, 1)

    def arm(self, arm: Arm) -> Arm:
        return arm.loaded(self.a / (GRAVITY * arm.com))
