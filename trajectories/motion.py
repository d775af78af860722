"""A planned motion: the ideal path as a smooth function of phase time, before sampling and ramps."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Rig

Space = Literal["platform", "joint"]
Sample = Callable[[Floats], tuple[Floats, Floats, Floats]]
"""Function from phase time (m,) [s] to position, first and second derivative, each (m, k)."""


@dataclass(frozen=True)
class PlannedMotion:
    """One repetition of a motion, in platform coordinates [m] or joint positions [rad or m]."""

    name: str
    description: str
    """Short description for the user."""
    space: Space
    duration: float
    """Phase time of one repetition [s]."""
    periodic: bool
    """True where phase time wraps and repetitions join smoothly."""
    definition: str
    """Numbers that define the motion, as text; input of the digest."""
    sample: Sample


def of_one_joint(rig: Rig, joint: int, pose: Floats, deviation: Sample) -> Sample:
    """Move `joint` (1 ... n) by `deviation` (m,) from `pose` (dof,) [rad or m]; the others hold.

    Raises:
        BadInput: there is no such joint.
    """
    if not 1 <= joint <= rig.dof:
        raise BadInput(f"--joint: 1 to {rig.dof} expected, {joint} found")
    direction = np.eye(rig.dof)[joint - 1]

    def sample(time: Floats) -> tuple[Floats, Floats, Floats]:
        position, velocity, acceleration = (np.outer(values, direction) for values in deviation(time))
        return pose + position, velocity, acceleration

    return sample
