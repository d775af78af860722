"""A planned motion: the ideal path as a smooth function of phase time, before sampling and ramps."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from recordings.recording import Floats

Space = Literal["platform", "joint"]


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
    sample: Callable[[Floats], tuple[Floats, Floats, Floats]]
    """Function from phase time (m,) [s] to position, first and second derivative, each (m, 3)."""
