"""What the moving platform of a delta robot does when its joints move."""

from dataclasses import dataclass
from weakref import WeakKeyDictionary

from ident.dynamics.motion import Motion
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
    """(n, 3, 3) platform velocity per joint velocity, Eq. (16); a force F there takes J' F at the joints."""


# The mechanism's regressor and several effects ask for the same motion's.
_known: WeakKeyDictionary[Motion, dict[Geometry, Platform]] = WeakKeyDictionary()


def platform(geometry: Geometry, motion: Motion) -> Platform:
    """The platform of a robot of this `geometry`: Appendix A, Eqs. (16) and (23); remembered with the `motion`."""
    known = _known.setdefault(motion, {})
    if geometry not in known:
        P, P_dot, P_ddot, J = kinematics.platform_motion(
            geometry, motion.position, motion.velocity, motion.acceleration
        )
        known[geometry] = Platform(P, P_dot, P_ddot, J)
    return known[geometry]
