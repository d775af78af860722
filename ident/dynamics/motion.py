"""The motion of a mechanism, as every regressor sees it."""

from dataclasses import dataclass

from recordings.recording import Floats


@dataclass(frozen=True, eq=False)
class Motion:
    """n instants of dof joints, evenly spaced in time; NaN where it is not known."""

    position: Floats
    """(n, dof) [rad]."""
    velocity: Floats
    """(n, dof) [rad/s]."""
    acceleration: Floats
    """(n, dof) [rad/s^2]."""
    direction: Floats
    """(n, dof) sgn of the velocity, averaged over the sample where the joint reverses within it."""
