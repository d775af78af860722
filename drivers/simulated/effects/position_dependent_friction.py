"""Dry friction that varies along the travel."""

import math

from drivers.simulated.effect import HiddenEffect, JointState, parameter


class PositionDependentFriction(HiddenEffect):
    """A cable that is bent more at some angles: dry friction grows by a (1 + sin(k q + phase))."""

    variables = ("position", "velocity")
    drawn_by_seed = False

    a: float = parameter(0.3, "N m", "half of what dry friction varies by", ge=0, le=10)
    k: float = parameter(3.0, "1/rad", "how fast it varies", ge=0.1, le=10, drawn=(2.0, 5.0))
    phase: float = parameter(0.0, "rad", "at joint angle zero", ge=-math.pi, le=math.pi, drawn=(-math.pi, math.pi))

    def friction(self, i: int, state: JointState) -> float:
        return self.a * (1 + math.sin(self.k * state.q[i] + self.phase))
