"""Different torque gain of one motor."""

from collections.abc import Mapping

from drivers.simulated.effect import HiddenEffect, parameter


class TorqueGainMismatch(HiddenEffect):
    """The torque gain of the joint is (1 + mismatch) times the rig's."""

    variables = ("load",)
    single_joint = True

    mismatch: float = parameter(0.05, "1", "relative difference", ge=-0.6, le=0.6)

    def gain(self) -> float:
        return 1 + self.mismatch

    def identified(self, joint: int, coulomb: float, found: Mapping[str, float]) -> Mapping[str, float]:
        return {"e": self.mismatch}
