"""Dry friction that varies along the travel."""

import math
from collections.abc import Mapping

from drivers.simulated.effect import HiddenEffect, JointState, at_knots, parameter


class PositionDependentFriction(HiddenEffect):
    """A bent cable, or a worn spot: dry friction grows by 2 a ((1 + sin(k q + phase)) / 2)^p."""

    variables = ("position", "velocity")
    drawn_by_seed = False

    a: float = parameter(0.3, "N m", "half of what dry friction varies by", ge=0, le=10)
    k: float = parameter(3.0, "1/rad", "how fast it varies", ge=0.1, le=10, drawn=(2.0, 5.0))
    phase: float = parameter(0.0, "rad", "at joint angle zero", ge=-math.pi, le=math.pi, drawn=(-math.pi, math.pi))
    p: float = parameter(1.0, "1", "1 for a wave; greater for a spot", ge=1, le=30, drawn=(1.0, 8.0))

    def friction(self, i: int, state: JointState) -> float:
        return float(2 * self.a * ((1 + math.sin(self.k * state.q[i] + self.phase)) / 2) ** self.p)

    def identified(self, joint: int, coulomb: float, found: Mapping[str, float]) -> Mapping[str, float]:
        return at_knots("f", joint, found, lambda angle: coulomb + self.friction(0, JointState(q=[angle])))
