"""Motion of a mechanism: the input of every regressor."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import TypeVar
from weakref import WeakKeyDictionary

from recordings.recording import Floats
from recordings.rig import Geometry

_T = TypeVar("_T")


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


def cached_for_motion(compute: Callable[[Geometry, Motion], _T]) -> Callable[[Geometry, Motion], _T]:
    """Keep the results of `compute` as long as their motion exists: many models and effects need the same ones."""
    results: WeakKeyDictionary[Motion, dict[Geometry, _T]] = WeakKeyDictionary()

    @wraps(compute)
    def cached(geometry: Geometry, motion: Motion) -> _T:
        of_motion = results.setdefault(motion, {})
        if geometry not in of_motion:
            of_motion[geometry] = compute(geometry, motion)
        return of_motion[geometry]

    return cached
