"""Motion of a delta robot's platform."""

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from ident.dynamics.motion import Motion
from recordings.recording import Floats
from recordings.rig import Geometry
from trajectories import kinematics

GRAVITY = -float(kinematics.GRAVITY[2])
"""[m/s^2], downwards."""


@dataclass(frozen=True, eq=False)
class Platform:
    """The moving platform at n instants."""

    velocity: Floats
    """(n, 3) [m/s]."""
    jacobian: Floats
    """(n, 3, 3) platform velocity per joint velocity, Eq. (16); a force F there needs J' F at the joints."""
    torque_per_mass: Floats
    """(n, 3) torque that moves and holds a mass of 1 kg at the platform [N m/kg], Eqs. (16), (23)."""
    torque_of_rods: Floats
    """(n, 3) torque that moves and lifts one uniform rod of 1 kg in each limb [N m]."""


_KNOWN: WeakKeyDictionary[Motion, dict[Geometry, Platform]] = WeakKeyDictionary()
"""What was computed, as long as its motion exists: many models and effects need the same."""


def platform(geometry: Geometry, motion: Motion) -> Platform:
    """Return the platform's motion, Appendix A, Eqs. (16) and (23).

    Raises:
        Unreachable: the mechanism does not close at some angles.
    """
    of_motion = _KNOWN.setdefault(motion, {})
    if geometry not in of_motion:
        of_motion[geometry] = _computed(geometry, motion)
    return of_motion[geometry]


def _computed(geometry: Geometry, motion: Motion) -> Platform:
    from ident.dynamics.arm_kernels import platform_along  # numba takes time to load

    signals = (motion.position, motion.velocity, motion.acceleration)
    result = Platform(*platform_along(kernel_constants(geometry), *map(np.ascontiguousarray, signals)))
    if (np.isnan(result.jacobian).any(axis=(1, 2)) & np.isfinite(motion.position).all(axis=1)).any():
        kinematics.forward(geometry, motion.position)  # says where it does not close
    return result


def kernel_constants(geometry: Geometry) -> Floats:
    """Return the constants of a delta robot in the order of the compiled kernels."""
    phi = np.array(geometry.phi)
    return np.array([geometry.L1, geometry.L2, geometry.R - geometry.r, GRAVITY, *np.cos(phi), *np.sin(phi)])
