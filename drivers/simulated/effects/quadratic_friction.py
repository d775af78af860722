"""Friction proportional to the square of speed."""

from drivers.simulated.effect import HiddenEffect, JointState, parameter


class QuadraticFriction(HiddenEffect):
    """Additional motor torque a v |v|, from churning of oil or air."""

    variables = ("velocity",)

    a: float = parameter(0.1, "N m s^2/rad^2", "torque per square of speed", ge=0, le=6)

    def torque(self, i: int, state: JointState) -> float:
        v = state.v[i]
        return self.a * v * abs(v)
