"""The strength at which something grows to a wanted size."""

import math
from collections.abc import Callable

_TRIALS = 10
_LONGEST_STRIDE = math.log(10)
"""On the logarithm of the strength."""


def solve(
    size: Callable[[float], float], wanted: float, *, start: float, largest: float, tolerance: float
) -> tuple[float, float] | None:
    """Strength up to `largest` that brings `size` of it nearest to `wanted`, and that size; None: never finite.

    `size` grows more or less; it is infinite beyond what is possible. Secant steps on the logarithms of strength and
    size, where most laws are straight lines, kept between what was too small and what was too large.
    """
    goal, most = math.log(wanted), math.log(largest)
    low, high = -math.inf, math.inf
    tried: list[tuple[float, float]] = []
    x = math.log(start)
    for _ in range(_TRIALS):
        # The exponential of a logarithm may miss the largest by its last bit.
        y = math.log(max(size(min(math.exp(x), largest)), 1e-9))
        if math.isfinite(y):
            tried.append((x, y))
        if abs(y - goal) < tolerance or (x >= most and y < goal):
            break
        low, high = (low, min(high, x)) if y > goal else (max(low, x), high)
        x = min(_between(_secant(tried, x, goal), low, high), most)
    if not tried:
        return None
    x, y = min(tried, key=lambda trial: abs(trial[1] - goal))
    return min(math.exp(x), largest), math.exp(y)


def _secant(tried: list[tuple[float, float]], x: float, goal: float) -> float:
    """Where the line through the last two trials, or one of slope 1, meets the goal."""
    if not tried:
        return x - _LONGEST_STRIDE
    x1, y1 = tried[-1]
    slope = 1.0
    if len(tried) > 1:
        x0, y0 = tried[-2]
        slope = max((y1 - y0) / (x1 - x0), 0.3) if x1 != x0 else 1.0
    return x1 + min(max((goal - y1) / slope, -_LONGEST_STRIDE), _LONGEST_STRIDE)


def _between(x: float, low: float, high: float) -> float:
    """x, or the middle where it lies outside."""
    if low < x < high:
        return x
    if math.isinf(low):
        return high - _LONGEST_STRIDE
    if math.isinf(high):
        return low + _LONGEST_STRIDE
    return (low + high) / 2
