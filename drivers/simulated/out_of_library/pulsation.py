"""A periodic disturbance with its own frequency."""

import math

from drivers.simulated.effect import HiddenEffect, JointState, parameter


class Pulsation(HiddenEffect):
    """Additional motor torque a sin(2 pi f t + phase), from a fan, a pump or a vibrating floor."""

    variables = ("frequency",)

    a: float = parameter(0.3, "N m", "amplitude", ge=0, le=5)
    f: float = parameter(7.37, "Hz", "frequency", ge=0.1, le=200, drawn=(4.0, 22.0))
    phase: float = parameter(0.0, "rad", "phase at power-on", ge=-math.pi, le=math.pi, drawn=(-math.pi, math.pi))

    def torque(self, i: int, state: JointState) -> float:
        return self.a * math.sin(2 * math.pi * self.f * state.t + self.phase)
