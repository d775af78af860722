"""Elasticity of the gear."""

import math

from drivers.simulated.effect import HiddenEffect, parameter
from drivers.simulated.model_xml import ShaftCoupling


class JointElasticity(HiddenEffect):
    """A spring of stiffness k = 1 / compliance between the motor (with the encoder) and the arm."""

    variables = ("load", "acceleration")

    compliance: float = parameter(2e-4, "rad/(N m)", "1/k: twist per torque", ge=0, le=4e-3)

    def couplings(self) -> tuple[ShaftCoupling, ...]:
        if self.compliance < _RIGID:
            return ()
        stiffness = 1 / self.compliance
        return (
            ShaftCoupling(stiffness=stiffness, damping=2 * _DAMPING_RATIO * math.sqrt(stiffness * _LIMB_INERTIA)),
        )


_RIGID = 1e-5
"""Compliance below which the spring's period is shorter than the plant's time step [rad/(N m)]."""
_DAMPING_RATIO = 0.03
"""Typical of steel with grease."""
_LIMB_INERTIA = 0.2
"""Approximate inertia on the spring [kg m^2]."""
