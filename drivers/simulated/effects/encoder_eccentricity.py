"""Eccentricity of the encoder disc."""

import math
from collections.abc import Mapping

import numpy as np

from drivers.simulated.effect import HiddenEffect, parameter, sine_and_cosine


class EncoderEccentricity(HiddenEffect):
    """The encoder reads q + a sin(N q + phase), N = 1 on the joint's shaft, the gear ratio on the motor's."""

    variables = ("position", "acceleration")

    a: float = parameter(5e-4, "rad", "amplitude, as an angle of the joint", ge=0, le=0.3)
    N: float = parameter(21.0, "1/turn", "turns of the disc per turn of the joint", ge=1, le=200)
    phase: float = parameter(0.0, "rad", "phase at joint angle zero", ge=-math.pi, le=math.pi)

    @classmethod
    def largest(cls) -> float:
        """Half a degree of the joint: from one degree on, somebody would have noticed."""
        return math.radians(0.5)

    @classmethod
    def draw_shape(cls, rng: np.random.Generator) -> dict[str, float]:
        return {"N": float(rng.choice((1.0, 21.0))), "phase": rng.uniform(-math.pi, math.pi)}

    def encoder(self, q: float) -> tuple[float, float]:
        angle = self.N * q + self.phase
        return self.a * math.sin(angle), self.a * self.N * math.cos(angle)

    def identified(self, joint: int, coulomb: float, found: Mapping[str, float]) -> Mapping[str, float]:
        return {"N": self.N} | sine_and_cosine(self.a, self.phase)
