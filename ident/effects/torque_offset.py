"""A constant torque; the same thing as Coulomb friction whose level differs by direction."""

import numpy as np

from ident.effects import Effect
from ident.mechanisms import Parameter
from ident.motion import Motion
from recordings.recording import Floats


def columns(motion: Motion) -> Floats:
    """One everywhere (n, dof, 1)."""
    ones: Floats = np.where(np.isfinite(motion.velocity), 1.0, np.nan)[:, :, None]
    return ones


effect = Effect(
    sentence="The drive must give a constant torque, whatever the joint does.",
    equation="a",
    coefficients=(Parameter("a", "{effort}", "the constant torque"),),
    axis="velocity",
    causes="an amplifier's zero, a cable's pull, a spring, or dry friction that differs between the directions",
    remedy="zero the amplifier's current or torque measurement, relieve the cables, record both directions equally",
    columns=columns,
)
