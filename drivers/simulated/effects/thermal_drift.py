"""Friction that decreases as the machine warms up."""

import math
from collections.abc import Mapping

from drivers.simulated.effect import HiddenEffect, JointState, parameter


class ThermalDrift(HiddenEffect):
    """With cold grease friction is higher by (a v + b sgn v) exp(-t / T), with a = b `viscous`."""

    variables = ("time", "velocity")
    cycles = 5

    b: float = parameter(0.4, "N m", "dry friction of the cold machine minus that of the warm one", ge=0, le=20)
    viscous: float = parameter(0.4, "s/rad", "viscous part over dry part", ge=0, le=5, drawn=(0.1, 0.8))
    T: float = parameter(15.0, "s", "time constant of warming, from power-on", ge=0.1, le=1e4, drawn=(6.0, 25.0))

    def torque(self, i: int, state: JointState) -> float:
        return self.b * self.viscous * state.v[i] * math.exp(-state.t / self.T)

    def friction(self, i: int, state: JointState) -> float:
        return self.b * math.exp(-state.t / self.T)

    def identified(self, joint: int, coulomb: float, found: Mapping[str, float]) -> Mapping[str, float]:
        return {"a": self.b * self.viscous, "b": self.b, "T": self.T}
