"""A motion: the ideal path as a smooth function of phase time, before it is sampled, started and stopped."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from recordings.recording import Floats

Space = Literal["platform", "joint"]


@dataclass(frozen=True)
class PlannedMotion:
    """What one repetition looks like, in platform coordinates [m] or joint angles [rad]."""

    name: str
    description: str
    """One sentence for a person."""
    space: Space
    duration: float
    """Phase time of one repetition [s]."""
    periodic: bool
    """True: phase time wraps, and repetitions follow each other smoothly."""
    definition: str
    """The numbers that define the motion, as text; what the digest is made of."""
    sample: Callable[[Floats], tuple[Floats, Floats, Floats]]
    """Phase time (m,) [s] to position, first and second derivative, each (m, 3)."""
