"""Largest values that a joint can have: those beyond them are mistakes, and their squares overflow."""

import numpy as np

from recordings.recording import Floats

LARGEST = {
    "position": 1e6,
    "command": 1e6,
    "velocity": 1e9,
    "voltage": 1e9,
    "effort": 1e9,
    "current": 1e9,
    "temperature": 1e6,
}
"""By quantity, in SI units: 160,000 turns, and more torque than any machine has."""


def first_implausible(values: Floats, quantity: str) -> tuple[int, ...] | None:
    """Index of the first of `values` that no joint has; None where there is none. Gaps are plausible."""
    wrong = np.abs(values) > LARGEST[quantity]
    return tuple(map(int, np.argwhere(wrong)[0])) if wrong.any() else None
