"""The torque of an effect that no formula describes as C, for a controller that steps the model.

The code is one joint's. It may use the names of the effect's parameters, the quantities of formulas (see `formula`;
of vectors J[i][d] and velocity[d]), i and DOF, the joint from 0 and the number of joints, and `first`, whether this
is the first step.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from recordings.recording import Floats

Constants = Callable[[Mapping[str, float], Floats], Mapping[str, Floats]]
"""Computes arrays by name, from the shapes by name and the coefficients (c,) of one joint."""


@dataclass(frozen=True, kw_only=True)
class CCode:
    """An effect in C99 for numbers of type `real`.

    Functions of <math.h> and numbers are written as for double; an export in single precision makes `sinf` of `sin`
    and `0.5f` of `0.5`.
    """

    expression: str = ""
    """Torque of an additive effect on joint `i` [N m or N]."""
    of_links: str = ""
    """The expression on a tree of links, where the formula is one of another mechanism."""
    statements: str = ""
    """What precedes the expression; of a signal effect: what corrects q, qd and qdd."""
    state: tuple[str, ...] = ()
    """Names of what is kept from step to step, one number for each joint; 0 at the start."""
    constants: Constants | None = None
    """Computes further constants that the code uses, as arrays."""
    impossible: Callable[[Mapping[str, float]], str | None] = lambda shapes: None
    """Return why an effect with these shapes cannot be stepped, or None."""
