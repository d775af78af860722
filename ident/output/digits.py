"""Digits of numbers in texts and tables."""

import math
from collections.abc import Sequence


def number(value: float | None, digits: int = 3) -> str:
    """Format `value` with that many significant digits, with an exponent only below 1e-5 and from 1e7 on."""
    if value is None or not math.isfinite(value):
        return "–"
    if value == 0:
        return "0"
    magnitude = math.floor(math.log10(abs(float(f"{value:.{digits - 1}e}"))))
    if not -5 <= magnitude < 7:
        return f"{value:.{digits - 1}e}"
    return f"{value:.{max(0, digits - 1 - magnitude)}f}"


def percent(share: float | None) -> str:
    """Format a share from 0 to 1 in percent, with one decimal near 0 and 1."""
    if share is None or not math.isfinite(share):
        return "–"
    if 0.9995 <= share < 1:
        return "> 99.9\u00a0%"
    one_decimal = abs(share) < 0.0995 or 0.99 < share < 1
    return f"{100 * share:.{1 if one_decimal and share else 0}f}\u00a0%"


def with_equal_decimals(values: Sequence[float]) -> list[str]:
    """Format numbers with the same decimals, such that the largest has two significant digits."""
    largest = max(map(abs, values), default=0.0)
    decimals = max(0, 1 - math.floor(math.log10(largest))) if largest else 0
    return [f"{value:.{decimals}f}" for value in values]


def interval(low: float, high: float) -> str:
    """Format an interval with two significant digits of its half width."""
    half = (high - low) / 2
    if not (math.isfinite(half) and half > 0):
        return f"{number(low)} to {number(high)}"
    decimals = max(0, 1 - math.floor(math.log10(half)))
    return f"{low:.{decimals}f} to {high:.{decimals}f}" if decimals < 9 else f"{low:.3g} to {high:.3g}"
