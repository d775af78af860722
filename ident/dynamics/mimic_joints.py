"""Joints of a tree of links that mimic driven ones, as the second finger of a gripper: `<mimic>` of a URDF.

    q = S q_d + o,    q' = S q_d',    q'' = S q_d''

By virtual work, the torque of the driven joints (d) is S' tau of that of all joints.
"""

from dataclasses import dataclass

import numpy as np

from recordings.recording import Floats, Ints
from recordings.urdf import Chain


@dataclass(frozen=True, eq=False)
class MimicJoints:
    """N joints, dof of them driven, and the others multiples of these."""

    driven: Ints
    """(dof,) driven joints, in the order of the recording's columns."""
    S: Floats
    """(N, dof) motion of each joint per motion of a driven one."""
    offset: Floats
    """(N,) positions with the driven joints at 0 [rad or m]."""

    def along(self, position: Floats, velocity: Floats, acceleration: Floats) -> tuple[list[Floats], Floats]:
        """Compute position, velocity, acceleration (n, N) of all joints, and S (n, N, dof), of the driven."""
        rows = [signal @ self.S.T for signal in (position, velocity, acceleration)]
        return [rows[0] + self.offset, *rows[1:]], np.broadcast_to(self.S, (len(position), *self.S.shape))

    def wandering(self, targets: Floats) -> Floats:
        """Positions (n, dof) of the driven joints: all of `targets` (n, dof), since none is out of reach."""
        return targets


def mimic_joints(chain: Chain, order: Ints) -> MimicJoints:
    """Return the joints of `chain` that mimic driven ones; order: (N,) places of the driven ones, then of these."""
    dof = len(chain.joints)
    S, offset = np.zeros((len(order), dof)), np.zeros(len(order))
    S[order[:dof]] = np.eye(dof)
    for place, name in zip(order[dof:].tolist(), chain.following, strict=True):
        mimicked, multiplier, offset[place] = chain.mimicking[name]
        S[place, chain.joints.index(mimicked)] = multiplier
    return MimicJoints(order[:dof], S, offset)
