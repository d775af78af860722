"""Motion of a mechanism: the input of every regressor."""

from dataclasses import dataclass

from recordings.recording import Floats


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion of dof joints at n evenly spaced instants; NaN where unknown."""

    position: Floats
    """(n, dof) [rad]."""
    velocity: Floats
    """(n, dof) [rad/s]."""
    acceleration: Floats
    """(n, dof) [rad/s^2]."""
    direction: Floats
    """(n, dof) sgn of the velocity, averaged over the sample where the joint reverses within it."""
