"""Stribeck friction of a loaded gear."""

import math

from drivers.simulated.effect import HiddenEffect, JointState, parameter


class StribeckLoadFriction(HiddenEffect):
    """Dry friction grows by a |load| exp(-(v / v_s)^2): teeth under load stick at low speed."""

    variables = ("load", "velocity")
    drawn_by_seed = False
    contains = ("load_dependent_friction",)

    a: float = parameter(0.1, "1", "fraction of the torque that is lost near standstill", ge=0, le=0.9)
    v_s: float = parameter(0.3, "rad/s", "Stribeck velocity", ge=1e-3, le=3, drawn=(0.1, 0.5))

    def friction(self, i: int, state: JointState) -> float:
        return self.a * abs(state.load[i]) * math.exp(-((state.v[i] / self.v_s) ** 2))
