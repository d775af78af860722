"""Load-dependent friction of a gear that loses less where the load drives the motor."""

from collections.abc import Mapping

from drivers.simulated.effect import HiddenEffect, JointState, parameter


class DirectionalLoadFriction(HiddenEffect):
    """Dry friction grows by a_d |load| where the motor drives the load, by a_d `back` |load| where it is driven."""

    variables = ("load", "velocity")
    single_joint = True
    drawn_by_seed = False
    contains = ("load_dependent_friction",)

    a_d: float = parameter(0.1, "1", "fraction of the torque that is lost where the motor drives", ge=0, le=0.8)
    back: float = parameter(0.3, "1", "a_b / a_d, of that where the load drives", ge=0, le=1, drawn=(0.0, 0.4))

    def friction(self, i: int, state: JointState) -> float:
        load = state.load[i]
        return self.a_d * abs(load) * (1.0 if load * state.v[i] > 0 else self.back)

    def identified(self, joint: int, coulomb: float, found: Mapping[str, float]) -> Mapping[str, float]:
        return {"a_d": self.a_d, "a_b": self.a_d * self.back}
