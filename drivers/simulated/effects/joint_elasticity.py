"""A gear that gives way."""

import math

from drivers.simulated.effect import HiddenEffect, parameter
from drivers.simulated.model_xml import Coupling


class JointElasticity(HiddenEffect):
    """A spring of stiffness k = 1 / compliance between motor, where the encoder sits, and arm."""

    variables = ("load", "acceleration")

    compliance: float = parameter(2e-4, "rad/(N m)", "1/k: twist per torque", ge=0, le=4e-3)

    def couplings(self) -> tuple[Coupling, ...]:
        if self.compliance < _RIGID:
            return ()
        stiffness = 1 / self.compliance
        return (Coupling(stiffness=stiffness, damping=2 * _DAMPING_RATIO * math.sqrt(stiffness * _LIMB_INERTIA)),)


_RIGID = 1e-5
"""Below this compliance the spring would swing faster than the plant's time steps [rad/(N m)]."""
_DAMPING_RATIO = 0.03
"""Steel and grease."""
_LIMB_INERTIA = 0.2
"""What swings on the spring, roughly [kg m^2]."""
