"""A constant torque."""

from drivers.simulated.effect import HiddenEffect, JointState, parameter


class TorqueOffset(HiddenEffect):
    """Additional constant motor torque a: pull of a cable, zero offset of an amplifier."""

    a: float = parameter(0.3, "N m", "the constant torque", ge=-5, le=5)

    def torque(self, i: int, state: JointState) -> float:
        return self.a
