"""Delta robot: Eqs. (26)-(29) as regressor columns, and Eqs. (1)-(2) with Table 1 as the reference model.

Differences from the printed equations:

- z points up and gravity is (0, 0, -9.81) m/s^2. The printed +g belongs to a z axis that points down, where a
  positive angle lowers the elbow. Reversing z, angles and torques changes only the sign of both gravity terms
  of (26): that of the arms becomes +T_g cos(theta), with T_g = m_A |g| L1 positive and comparable with (36).
- Friction is positive where it opposes motion: +c_v theta_dot + c_c sgn(theta_dot). (28)-(29) subtract it; the values
  of (36) have the opposite sign.
- (23) and the second line of (25) print J theta_dot where J_dot theta_dot is meant, as in (28).
"""

from dataclasses import dataclass

import numpy as np

from ident.dynamics.mechanisms import Parameter, friction_parameters
from ident.dynamics.motion import Motion
from ident.dynamics.platform import GRAVITY, platform
from recordings.recording import Floats
from recordings.rig import Geometry, Nominal, Rig
from recordings.urdf import Vector

PARAMETERS = (
    Parameter("m_p", "kg", "mass moved with the platform: platform and forearms", nonnegative=True),
    Parameter("T_g", "N m", "torque that holds one actuated arm level against gravity"),
    *(Parameter(f"I_{i}", "kg m^2", f"inertia of arm {i} and its motor", nonnegative=True) for i in (1, 2, 3)),
    *friction_parameters(("revolute",) * 3, paper_sign=-1),
)
"""In the order of Eq. (30)."""


def create(rig: Rig) -> "Delta":
    """Create the delta robot described by `rig`."""
    return Delta(rig.geometry, rig.nominal)


@dataclass(frozen=True)
class Delta:
    """A three-limb delta robot."""

    geometry: Geometry
    nominal: Nominal

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The 11 parameters of Eq. (30)."""
        return PARAMETERS

    def regressor(self, motion: Motion) -> Floats:
        """Compute the columns (n, 3, 11) of Eq. (26): the derivatives of (27)-(29) by the parameters of (30)."""
        platform_motion = platform(self.geometry, motion)
        columns = np.zeros((*motion.position.shape, len(PARAMETERS)))
        columns[:, :, 0] = platform_motion.torque_per_mass
        columns[:, :, 1] = np.cos(motion.position)
        per_joint = (motion.acceleration, motion.velocity, motion.direction)
        for first, signal in zip((2, 5, 8), per_joint, strict=True):
            joint = np.arange(3)
            columns[:, joint, first + joint] = signal
        return columns

    def inertia(self, motion: Motion, parameters: Floats) -> Floats:
        """Compute D (n, 3, 3) [kg m^2], Eq. (27): the arms on the diagonal, and m_p J' J, which couples joints."""
        jacobian = platform(self.geometry, motion).jacobian
        return parameters[0] * np.einsum("nki,nkj->nij", jacobian, jacobian) + np.diag(parameters[2:5])

    def gravity(self, motion: Motion, parameters: Floats) -> Floats:
        """Compute the torque (n, 3) [N m] that holds platform and arms at rest, Eq. (29) without friction."""
        lift = GRAVITY * platform(self.geometry, motion).jacobian[:, 2]
        return parameters[0] * lift + parameters[1] * np.cos(motion.position)

    def torque_per_mass(self, motion: Motion, place: Vector) -> Floats:
        """Compute the torque (n, 3) [N m/kg] of 1 kg on the platform, which does not turn: the same at any place."""
        return platform(self.geometry, motion).torque_per_mass

    def nominal_torque(self, motion: Motion) -> Floats:
        """Compute the torque (n, 3) [N m] of Eqs. (1)-(2) with the values of Table 1, without friction.

        As printed, with g = -9.81: the mass of the rods counts on the platform and again on the arms, and the arms'
        inertia is about their centres of mass. The multipliers (2) do virtual work on the platform.
        """
        geometry, nominal = self.geometry, self.nominal
        inertia = nominal.motor_inertia + nominal.I_L1 + geometry.L1**2 * nominal.m_d
        first_moment = nominal.m_a * nominal.L1c + nominal.m_d * geometry.L1
        torque: Floats = inertia * motion.acceleration + first_moment * GRAVITY * np.cos(motion.position)
        return torque + (nominal.m_p + 3 * nominal.m_d) * platform(geometry, motion).torque_per_mass
