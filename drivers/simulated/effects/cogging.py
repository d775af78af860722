"""Cogging torque of the motor."""

import math
from collections.abc import Mapping

import numpy as np

from drivers.simulated.effect import HiddenEffect, JointState, parameter, sine_and_cosine


class Cogging(HiddenEffect):
    """Additional motor torque a sin(N q + phase), with N periods per turn of the joint, from magnets and teeth."""

    variables = ("position",)

    a: float = parameter(0.3, "N m", "amplitude", ge=0, le=5)
    N: float = parameter(42.0, "1/turn", "periods per turn of the joint", ge=1, le=1000)
    phase: float = parameter(0.0, "rad", "phase at joint angle zero", ge=-math.pi, le=math.pi)

    @classmethod
    def draw_shape(cls, rng: np.random.Generator) -> dict[str, float]:
        return {"N": float(rng.integers(10, 50)), "phase": rng.uniform(-math.pi, math.pi)}

    def torque(self, i: int, state: JointState) -> float:
        return self.a * math.sin(self.N * state.q[i] + self.phase)

    def identified(self, joint: int, coulomb: float, found: Mapping[str, float]) -> Mapping[str, float]:
        return {"N": self.N} | sine_and_cosine(self.a, self.phase)
