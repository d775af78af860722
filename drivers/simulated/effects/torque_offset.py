"""A constant torque."""

import numpy as np

from drivers.simulated.effect import HiddenEffect, JointState, draw_sign, parameter


class TorqueOffset(HiddenEffect):
    """Additional constant motor torque a: pull of a cable, zero offset of an amplifier."""

    a: float = parameter(0.3, "N m", "the constant torque", ge=-5, le=5)

    @classmethod
    def draw_shape(cls, rng: np.random.Generator) -> dict[str, float]:
        return {"a": draw_sign(rng, 0.3)}

    def torque(self, i: int, state: JointState) -> float:
        return self.a
