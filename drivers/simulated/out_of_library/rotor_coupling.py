"""Inertial coupling of motors."""

from drivers.simulated.effect import HiddenEffect, JointState, parameter


class RotorCoupling(HiddenEffect):
    """Additional motor torque J times the others' acceleration, from a flywheel driven through a differential."""

    variables = ("acceleration",)
    between_joints = True

    J: float = parameter(0.01, "kg m^2", "mutual inertia", ge=0, le=0.2)

    def torque(self, i: int, state: JointState) -> float:
        return self.J * sum(state.a[joint - 1] for joint in self.joints if joint != i + 1)
