"""The torque of an effect as C, for a controller that steps the model.

The code is one joint's, and may use the names of the effect's parameters and these (SI units):

    q, qd, qdd, direction     motion of the joint, corrected; the sign of its velocity
    i, DOF                    the joint, from 0, and the number of joints
    t, dt                     time since the start, and since the last step
    temperature               of the joint's drive [degC]
    rigid                     the joint's torque without friction and effects
    load                      the same with that of the effects on the arms
    c_v, c_c                  the joint's viscous and Coulomb friction
    m_p, T_g, m_d, L1         parameters and length of a delta robot; cos_phi, sin_phi: direction of its limb
    J[i][d]                   platform velocity along axis d per velocity of joint i, Eq. (16)
    velocity[d]               of the platform
    torque_per_mass, rods     the joint's torque for 1 kg at the platform, and for rods of 1 kg
    first                     whether this is the first step
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from recordings.recording import Floats

Constants = Callable[[Mapping[str, float], Floats], Mapping[str, Floats]]
"""Computes arrays by name, from the shapes by name and the coefficients (c,) of one joint."""


@dataclass(frozen=True, kw_only=True)
class CCode:
    """An effect in C99; `sin`, `exp` and the like are those of <tgmath.h>, `real` is double or float."""

    expression: str = ""
    """Torque of an additive effect on joint `i` [N m or N]."""
    statements: str = ""
    """What precedes the expression; of a signal effect: what corrects q, qd and qdd."""
    state: tuple[str, ...] = ()
    """Names of what is kept from step to step, one number for each joint; 0 at the start."""
    constants: Constants | None = None
    """Computes further constants that the code uses, as arrays."""
    impossible: Callable[[Mapping[str, float]], str | None] = lambda shapes: None
    """Return why an effect with these shapes cannot be stepped, or None."""
