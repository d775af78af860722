"""Motors that hold on to each other."""

from drivers.simulated.effect import HiddenEffect, JointState, parameter


class RotorCoupling(HiddenEffect):
    """A flywheel that several motors turn through a differential: each must give J times the others' acceleration."""

    variables = ("acceleration",)
    between_joints = True

    J: float = parameter(0.01, "kg m^2", "mutual inertia", ge=0, le=0.2)

    def torque(self, i: int, now: JointState) -> float:
        return self.J * sum(now.a[joint - 1] for joint in self.joints if joint != i + 1)
