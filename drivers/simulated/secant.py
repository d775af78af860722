"""Secant search for the strength at which an effect has a given size."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from drivers.simulated.effect import HiddenEffect
from recordings.recording import Floats

TOLERANCE = 0.01
"""Relative tolerance of a requested size."""
_MAX_TRIALS = 10
_MAX_LOG_STEP = math.log(10)
"""Longest step in the logarithm of the strength."""


def unabsorbed(change: Floats, contained: Sequence[Floats]) -> Floats:
    """What changes of residuals (m, 3) by effects that an effect contains cannot absorb of its own `change`."""
    if not contained:
        return change
    matrix = np.stack([each.ravel() for each in contained], axis=1)
    fitted: Floats = matrix @ np.linalg.lstsq(matrix, change.ravel(), rcond=None)[0]
    return change - fitted.reshape(change.shape)


def nearest(
    size: Callable[[HiddenEffect], float], effect: HiddenEffect, target_size: float
) -> tuple[HiddenEffect, float] | None:
    """The effect with the strength, of the same sign, whose `size` is nearest to `target_size`, and that size.

    None: no strength tried has a finite size.
    """
    strength = effect.strength()
    sign = math.copysign(1.0, getattr(effect, strength))
    solution = solve(
        lambda trial: size(effect.scaled(sign * trial)),
        target_size,
        start=abs(getattr(type(effect)(), strength)),
        largest=effect.largest(),
    )
    return None if solution is None else (effect.scaled(sign * solution[0]), solution[1])


def solve(
    size: Callable[[float], float], target_size: float, *, start: float, largest: float
) -> tuple[float, float] | None:
    """Strength up to `largest` whose `size` is nearest to `target_size`, and that size; None: never finite.

    `size` is roughly increasing, and infinite where the strength is impossible. Secant steps on the logarithms of
    strength and size, where most laws are straight lines, safeguarded by a bracket.
    """
    goal, upper = math.log(target_size), math.log(largest)
    low, high = -math.inf, math.inf
    trials: list[tuple[float, float]] = []
    x = math.log(start)
    for _ in range(_MAX_TRIALS):
        # The exponential of a logarithm may exceed the largest by its last bit.
        y = math.log(max(size(min(math.exp(x), largest)), 1e-9))
        if math.isfinite(y):
            trials.append((x, y))
        if abs(y - goal) < TOLERANCE or (x >= upper and y < goal):
            break
        low, high = (low, min(high, x)) if y > goal else (max(low, x), high)
        x = min(_bracketed(_secant(trials, x, goal), low, high), upper)
    if not trials:
        return None
    x, y = min(trials, key=lambda trial: abs(trial[1] - goal))
    return min(math.exp(x), largest), math.exp(y)


def _secant(trials: list[tuple[float, float]], x: float, goal: float) -> float:
    """Intersection of the goal with the line through the last two trials, or with a line of slope 1."""
    if not trials:
        return x - _MAX_LOG_STEP
    x1, y1 = trials[-1]
    slope = 1.0
    if len(trials) > 1:
        x0, y0 = trials[-2]
        slope = max((y1 - y0) / (x1 - x0), 0.3) if x1 != x0 else 1.0
    return x1 + min(max((goal - y1) / slope, -_MAX_LOG_STEP), _MAX_LOG_STEP)


def _bracketed(x: float, low: float, high: float) -> float:
    """x, or the middle of the bracket if x lies outside."""
    if low < x < high:
        return x
    if math.isinf(low):
        return high - _MAX_LOG_STEP
    if math.isinf(high):
        return low + _MAX_LOG_STEP
    return (low + high) / 2
