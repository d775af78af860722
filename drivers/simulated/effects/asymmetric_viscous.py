"""Direction-dependent viscous friction."""

from drivers.simulated.effect import HiddenEffect, JointState, parameter


class AsymmetricViscous(HiddenEffect):
    """Additional motor torque a |v|: an oil seal or a gear has more friction in one direction than in the other."""

    variables = ("velocity",)

    a: float = parameter(0.2, "N m s/rad", "half of the difference of the two directions' coefficients", ge=-3, le=3)

    def torque(self, i: int, state: JointState) -> float:
        return self.a * abs(state.v[i])
