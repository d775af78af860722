"""A constant torque."""

import numpy as np

from drivers.simulated.effect import Effect, parameter


class TorqueOffset(Effect):
    """The motor must give a constant torque a, whatever the robot does: a cable's pull, an amplifier's zero."""

    a: float = parameter(0.3, "N m", "the constant torque", ge=-5, le=5)

    @classmethod
    def draw_shape(cls, rng: np.random.Generator) -> dict[str, float]:
        return {"a": float(rng.choice((-1.0, 1.0)))}

    def torque(self, q: float, v: float) -> float:
        return self.a
