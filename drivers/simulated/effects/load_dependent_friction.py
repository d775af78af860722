"""Load-dependent friction of the gear."""

from drivers.simulated.effect import HiddenEffect, JointState, parameter


class LoadDependentFriction(HiddenEffect):
    """The gear loses the fraction a of the torque that it transmits: dry friction grows by a |load|."""

    variables = ("load", "velocity")

    a: float = parameter(0.05, "1", "fraction of the torque that is lost", ge=0, le=0.5)

    def friction(self, i: int, state: JointState) -> float:
        return self.a * abs(state.load[i])
