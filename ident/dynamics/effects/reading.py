"""True positions from what an encoder reads."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from ident.dynamics.effects.formula import Formula, derivative, evaluate, traced
from recordings.recording import Floats

ITERATIONS = 3
"""Steps of Newton's method: the reading is nearly the position."""
MIN_SLOPE = 0.1
"""Smallest slope of a reading that is believed."""


@dataclass(frozen=True)
class PositionCorrection:
    """The inverse of a `reading`, a formula of the true position q, with parameters and shapes by name."""

    reading: Formula
    values: Mapping[str, Floats]

    def __call__(self, measured: Floats) -> Floats:
        """Solve reading(q) = measured for the true positions q (n, dof), by Newton's method."""
        true = measured
        for _ in range(ITERATIONS):
            slope = np.maximum(self._derivative(1, true), MIN_SLOPE)
            true = true - (self.reading(q=true, **self.values) - measured) / slope
        return true

    def slopes(self, true: Floats) -> tuple[Floats, Floats]:
        """First and second derivative (n, dof) of the true position by the measured one, at `true` positions."""
        slope, bend = (self._derivative(order, true) for order in (1, 2))
        return 1 / slope, -bend / slope**3

    def _derivative(self, order: int, true: Floats) -> Floats:
        """First or second derivative (n, dof) of the reading by the true position."""
        values = {"q": true, **self.values}
        return evaluate(derivatives(self.reading)[order - 1], values) + 0 * true


@cache
def derivatives(reading: Formula) -> tuple[object, object]:
    """First and second derivative of a `reading` by the true position, as expressions."""
    (expression,) = traced(reading)
    slope = derivative(expression, "q")
    return slope, derivative(slope, "q")
