"""Backlash of the gear."""

from drivers.simulated.effect import HiddenEffect, parameter
from drivers.simulated.model_xml import ShaftCoupling


class Backlash(HiddenEffect):
    """A gap of width 2 b between the motor (with the encoder) and the arm; inelastic impact of the teeth."""

    variables = ("position", "velocity", "load")

    b: float = parameter(0.001, "rad", "half of the gap, as an angle of the joint", ge=0, le=0.03)

    def couplings(self) -> tuple[ShaftCoupling, ...]:
        return (ShaftCoupling(gap=self.b, damping=_OIL),) if self.b else ()


_OIL = 0.02
"""Viscous damping between motor and arm inside the gap [N m s/rad]."""
