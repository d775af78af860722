"""Which parameters this motion tells apart, from the singular values of the regressor.

Columns are brought to one length first, or their units would decide. A small singular value is a combination of
parameters that hardly changes the torque, so the data cannot know it; which parameters suffer is told by the share of
their variance that comes from there: Belsley, Kuh, Welsch, "Regression Diagnostics" (1980), section 3.2.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ident.dynamics.mechanisms import Parameter
from recordings.recording import Floats

Status = Literal["identifiable", "weak", "not"]

WEAK = 30.0
"""Largest singular value over this one, from which a combination is only weakly known (the book's limit)."""
UNIDENTIFIABLE = 1e6
"""The same, from which it is not known: round-off and the motion's own noise are of that order."""
_ROUNDING = np.sqrt(np.finfo(np.float64).eps)
"""Singular values from products of columns are no more exact than this."""
_MOST = 0.5
"""Share of a parameter's variance that makes it suffer from a combination."""
_MEMBER = 0.3
"""A parameter belongs to a combination from this share of the largest part on."""


@dataclass(frozen=True)
class Combination:
    """Parameters that the data cannot tell apart, or hardly."""

    names: tuple[str, ...]
    """The one that contributes most first."""
    status: Literal["weak", "not"]
    share: float
    """How far the torque changes along the combination, over how far it would by the first parameter alone."""
    sentence: str


@dataclass(frozen=True)
class Identifiability:
    """What the motion tells about k parameters."""

    condition: float
    """Largest over smallest singular value."""
    singular_values: tuple[float, ...]
    """Of columns of length one."""
    status: tuple[Status, ...]
    """(k,)."""
    combinations: tuple[Combination, ...]


def identifiability(gram: Floats, parameters: Sequence[Parameter]) -> Identifiability:
    """From `gram` (k, k), the products of the regressor's columns summed over all samples."""
    length = np.sqrt(np.diag(gram))
    squares, directions = np.linalg.eigh(gram / np.outer(length, length))
    singular = np.sqrt(np.maximum(squares, 0.0))[::-1]
    directions = directions[:, ::-1]
    index = singular[0] / np.maximum(singular, _ROUNDING * singular[0])
    parts = (directions * index) ** 2
    shares = parts / parts.sum(axis=1, keepdims=True)
    weak, lost = shares[:, index >= WEAK].sum(axis=1), shares[:, index >= UNIDENTIFIABLE].sum(axis=1)
    status = tuple(_status(*suffered) for suffered in zip(weak, lost, strict=True))
    combinations = [
        _combination(directions[:, i], singular[i], length, parameters, "not" if index[i] >= UNIDENTIFIABLE else "weak")
        for i in np.flatnonzero(index >= WEAK)
    ]
    return Identifiability(float(index[-1]), tuple(singular.tolist()), status, tuple(combinations))


def _status(weak: float, lost: float) -> Status:
    if lost >= _MOST:
        return "not"
    return "weak" if weak >= _MOST else "identifiable"


def _combination(
    direction: Floats,
    singular: float,
    length: Floats,
    parameters: Sequence[Parameter],
    status: Literal["weak", "not"],
) -> Combination:
    order = [int(i) for i in np.argsort(-np.abs(direction)) if abs(direction[i]) >= _MEMBER * np.abs(direction).max()]
    step = direction / length
    step = step / step[order[0]]
    changes = [f"{parameters[i].name} by {step[i]:+.3g} {parameters[i].unit}" for i in order]
    share = float(singular / np.abs(direction).max())
    names = tuple(parameters[i].name for i in order)
    effect = "next to nothing" if share < _ROUNDING else f"only {100 * share:.2g} % of what {names[0]} alone would do"
    known = "cannot be told apart" if status == "not" else "can hardly be told apart"
    sentence = f"{', '.join(names)} {known} by this motion: {' and '.join(changes)} together do {effect}"
    return Combination(names, status, share, sentence)
