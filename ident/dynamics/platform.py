"""Motion of a delta robot's platform."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ident.dynamics.motion import Motion, cached_for_motion
from recordings.recording import Floats
from recordings.rig import Geometry
from trajectories import kinematics


@dataclass(frozen=True, eq=False)
class Platform:
    """The moving platform at n instants."""

    position: Floats
    """(n, 3) [m]."""
    velocity: Floats
    """(n, 3) [m/s]."""
    acceleration: Floats
    """(n, 3) [m/s^2]."""
    jacobian: Floats
    """(n, 3, 3) platform velocity per joint velocity, Eq. (16); a force F there needs J' F at the joints."""

    @property
    def lift(self) -> Floats:
        """(n, 3) acceleration minus that of gravity [m/s^2]: the force per mass that moves and holds a body there."""
        return self.acceleration - kinematics.GRAVITY

    @cached_property
    def torque_per_mass(self) -> Floats:
        """(n, 3) torque that moves and holds a mass of 1 kg at the platform [N m/kg], Eqs. (16), (23)."""
        torque: Floats = np.einsum("nji,nj->ni", self.jacobian, self.lift)
        return torque


@cached_for_motion
def platform(geometry: Geometry, motion: Motion) -> Platform:
    """Compute the platform's motion, Appendix A, Eqs. (16) and (23); cached as long as `motion` exists."""
    return Platform(*kinematics.platform_motion(geometry, motion.position, motion.velocity, motion.acceleration))
