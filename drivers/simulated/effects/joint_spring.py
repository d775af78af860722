"""A spring between base and arm."""

from collections.abc import Mapping

from drivers.simulated.effect import HiddenEffect, JointState, parameter


class JointSpring(HiddenEffect):
    """An elastic part, such as a stiff cable loop, pulls the joint to a rest angle: k (q - q_0)."""

    variables = ("position",)

    k: float = parameter(1.0, "N m/rad", "stiffness", ge=0, le=20)
    q_0: float = parameter(0.2, "rad", "rest angle", ge=-1.5, le=1.5, drawn=(-0.5, 0.5))

    def torque(self, i: int, state: JointState) -> float:
        return self.k * (state.q[i] - self.q_0)

    def identified(self, joint: int, coulomb: float, found: Mapping[str, float]) -> Mapping[str, float]:
        return {"k": self.k, "a": -self.k * self.q_0}
