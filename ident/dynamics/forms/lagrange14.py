"""Conventional linear model of the delta robot, Eqs. (37)-(40): 14 parameters, no friction.

(1) is made linear by taking the Lagrangian multipliers as constants, (38), although by (2) they depend on the motion.
Kept as printed, because RLS, DLS and SVD use it in Table 2.

Differences from the printed equations, none of which changes the torque that the columns can express:

- Positions are in our frame (z up); parameters of columns that change sign with it have the opposite sign.
- The coefficient of -cos(theta) is in N m: (38) prints m_a L1c + m_d L1 and leaves out g.
- (39) repeats psi_2 where psi_3 is meant, and (40) is printed as two rows for each joint.
"""

from dataclasses import dataclass

import numpy as np

from ident.dynamics.mechanisms import Parameter, RigidMechanism, delta
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from recordings.rig import Rig
from recordings.urdf import Vector
from trajectories import kinematics

MECHANISM = "delta"

_COLUMNS = ((1, 2, 3, 5), (6, 7, 8, 9), (10, 11, 12, 13))
"""Indices of the columns P_x, P_y, P_z and sin of each joint in (40)."""


def _parameters() -> tuple[Parameter, ...]:
    """Return the parameters in the order of Eq. (38)."""
    meanings = {1: ("kg m^2", "inertia of an arm, its motor and forearm"), 5: ("N m", "weight of an arm")}
    for limb, columns in enumerate(_COLUMNS, start=1):
        multiplier = f"2 L1 lambda_{limb}"
        texts = (f"{multiplier} cos phi_{limb}", f"{multiplier} sin phi_{limb}", multiplier, f"{multiplier} (R - r)")
        for column, unit, text in zip(columns, ("N", "N", "N", "N m"), texts, strict=True):
            meanings[column + 1] = (unit, f"{text}, with a constant multiplier")
    return tuple(Parameter(f"theta_{i}", *meanings[i]) for i in range(1, 15))


PARAMETERS = _parameters()


def create(rig: Rig) -> RigidMechanism:
    """Create the conventional linear model of the delta robot described by `rig`."""
    return Lagrange14(delta.create(rig))


@dataclass(frozen=True)
class Lagrange14:
    """Eq. (39): torque = Psi theta, with 14 parameters that are constant by assumption."""

    delta: delta.Delta

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The 14 parameters of Eq. (38)."""
        return PARAMETERS

    def regressor(self, motion: Motion) -> Floats:
        """Compute the columns (n, 3, 14) of Eq. (40)."""
        theta = motion.position
        P = kinematics.forward(self.delta.geometry, theta)
        sin, cos = np.sin(theta), np.cos(theta)
        columns = np.zeros((*theta.shape, len(PARAMETERS)))
        columns[:, :, 0] = motion.acceleration
        columns[:, :, 4] = -cos
        for joint, (x, y, z, constant) in enumerate(_COLUMNS):
            columns[:, joint, x] = -P[:, 0] * sin[:, joint]
            columns[:, joint, y] = -P[:, 1] * sin[:, joint]
            columns[:, joint, z] = P[:, 2] * cos[:, joint]
            columns[:, joint, constant] = sin[:, joint]
        return columns

    def inertia(self, motion: Motion, parameters: Floats) -> Floats:
        """Compute the inertia matrix (n, 3, 3) [kg m^2]: diagonal, as the multipliers are taken as constants."""
        return np.broadcast_to(parameters[0] * np.eye(3), (len(motion.position), 3, 3))

    def gravity(self, motion: Motion, parameters: Floats) -> Floats:
        """Compute the torque (n, 3) [N m] of all columns but that of the acceleration."""
        return self.regressor(motion)[:, :, 1:] @ parameters[1:]

    def torque_per_mass(self, motion: Motion, place: Vector) -> Floats:
        """Compute the torque (n, 3) [N m/kg] of 1 kg on the platform."""
        return self.delta.torque_per_mass(motion, place)

    def nominal_torque(self, motion: Motion) -> Floats:
        """Compute the torque (n, 3) [N m] of Eqs. (1)-(2) with the values of Table 1, without friction."""
        return self.delta.nominal_torque(motion)
