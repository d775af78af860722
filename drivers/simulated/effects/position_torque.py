"""Torque of something that the arm runs into or pulls taut."""

from collections.abc import Mapping

from drivers.simulated.effect import HiddenEffect, JointState, at_knots, parameter


class PositionTorque(HiddenEffect):
    """A stop of rubber inside the travel, or a cable that tightens: a max(q - q_0, 0)^p."""

    variables = ("position",)
    drawn_by_seed = False

    a: float = parameter(5.0, "N m/rad^p", "how hard it is", ge=0, le=1e4)
    q_0: float = parameter(-0.5, "rad", "where it begins", ge=-1.5, le=1.5, drawn=(-0.3, 0.0))
    p: float = parameter(2.0, "1", "2 for rubber; a cable tightens more steeply", ge=1, le=8, drawn=(2.0, 5.0))

    def torque(self, i: int, state: JointState) -> float:
        return float(self.a * max(state.q[i] - self.q_0, 0.0) ** self.p)

    def identified(self, joint: int, coulomb: float, found: Mapping[str, float]) -> Mapping[str, float]:
        return at_knots("g", joint, found, lambda angle: self.torque(0, JointState(q=[angle])))
