"""Motion of a mechanism: the input of every regressor."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

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
    sample_time: float = 0.0
    """Time over which the samples are averaged [s]; 0: they are of instants."""

    @property
    def sweep(self) -> Floats:
        """(n, dof) half the change of the velocity within a sample [rad/s]."""
        return self.acceleration * (self.sample_time / 2)


def inertia_matrix(torque: Callable[[Motion], Floats], position: Floats) -> Floats:
    """D (n, dof, dof) at `position` (n, dof): column j is the `torque` (n, dof) of a unit acceleration of joint j."""
    still = np.zeros_like(position)
    at_rest = torque(Motion(position, still, still, still))
    columns = [torque(Motion(position, still, still + unit, still)) - at_rest for unit in np.eye(position.shape[1])]
    return np.stack(columns, axis=2)
