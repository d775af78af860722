"""Friction of hoses between two arms."""

from drivers.simulated.effect import HiddenEffect, JointState, parameter


class HoseDrag(HiddenEffect):
    """Additional motor torque c times the joint's speed relative to each of the other joints."""

    variables = ("velocity",)
    between_joints = True

    c: float = parameter(0.2, "N m s/rad", "torque per relative speed", ge=0, le=5)

    def torque(self, i: int, state: JointState) -> float:
        v = state.v
        return self.c * sum(v[i] - v[joint - 1] for joint in self.joints)
