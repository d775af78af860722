"""Different torque gain of one motor."""

import numpy as np

from drivers.simulated.effect import HiddenEffect, draw_joints, parameter


class TorqueGainMismatch(HiddenEffect):
    """The torque gain of the joint is (1 + mismatch) times the rig's."""

    variables = ("load",)

    mismatch: float = parameter(0.05, "1", "relative difference", ge=-0.6, le=0.6)

    @classmethod
    def draw_joints(cls, rng: np.random.Generator) -> tuple[int, ...]:
        return draw_joints(rng, 1)

    def gain(self) -> float:
        return 1 + self.mismatch
