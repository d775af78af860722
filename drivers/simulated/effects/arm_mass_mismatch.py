"""Additional mass on one arm."""

from dataclasses import replace

from drivers.simulated.effect import HiddenEffect, parameter
from drivers.simulated.model_xml import GRAVITY, Arm


class ArmMassMismatch(HiddenEffect):
    """A mass at the arm's centre of mass; the holding torque is a cos q higher, the inertia grows as well."""

    variables = ("position",)
    single_joint = True

    a: float = parameter(0.5, "N m", "its weight times its distance from the shoulder", ge=0, le=8)

    def arm(self, arm: Arm) -> Arm:
        return replace(arm, mass=arm.mass + self.a / (GRAVITY * arm.com))
