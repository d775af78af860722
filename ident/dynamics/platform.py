"""Motion of a delta robot's platform."""

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
    """(n, 3, 3) platform velocity per joint velocity, Eq. (16); a force F there needs J' F at the joints."""


# The mechanism's regressor and several effects use the platform of the same motion.
_cache: WeakKeyDictionary[Motion, dict[Geometry, Platform]] = WeakKeyDictionary()


def platform(geometry: Geometry, motion: Motion) -> Platform:
    """Compute the platform's motion, Appendix A, Eqs. (16) and (23); cached as long as `motion` exists."""
    cached = _cache.setdefault(motion, {})
    if geometry not in cached:
        P, P_dot, P_ddot, J = kinematics.platform_motion(
            geometry, motion.position, motion.velocity, motion.acceleration
        )
        cached[geometry] = Platform(P, P_dot, P_ddot, J)
    return cached[geometry]
