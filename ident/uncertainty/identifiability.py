"""Identifiability of the parameters from a motion, by the singular values of the regressor.

Columns are first scaled to unit length, so that units have no influence. A small singular value belongs to a
combination of parameters that hardly changes the torque. A parameter is affected if a large share of its variance
comes from such a combination: Belsley, Kuh, Welsch, "Regression Diagnostics" (1980), section 3.2.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np

from ident.dynamics.mechanisms import Parameter
from recordings.recording import Floats

Status = Literal["identifiable", "weak", "not"]

WEAK = 30.0
"""Condition index (largest singular value over this one) from which a combination is weakly known (book's limit)."""
UNIDENTIFIABLE = 1e6
"""Condition index from which a combination is not known: rounding and noise of the motion are of that order."""
_ROUNDING = np.sqrt(np.finfo(np.float64).eps)
"""Relative accuracy of singular values computed from products of columns."""
_AFFECTED_SHARE = 0.5
"""A parameter is affected from this share of its variance on."""
_MAX_CORRELATION = 0.95
"""Parameters whose errors correlate by more are known only together: each variance is ten times what it would be
without the other (variance inflation factor)."""
_IMITATION = (WEAK**2 - 1) / (WEAK**2 + 1)
"""The same for an effect and a parameter of the base model: their two columns have the condition index from which a
combination is weakly known. Effects that are really there correlate by up to 0.97 with friction."""
_MEMBER_SHARE = 0.3
"""A parameter belongs to a combination from this share of the largest entry on."""


@dataclass(frozen=True)
class Combination:
    """Parameters that the data cannot distinguish, or hardly."""

    names: tuple[str, ...]
    """In descending order of contribution."""
    status: Literal["weak", "not"]
    sentence: str


@dataclass(frozen=True)
class Identifiability:
    """Identifiability of k parameters from a motion."""

    condition: float
    """Largest over smallest singular value."""
    singular_values: tuple[float, ...]
    """Of the columns scaled to unit length."""
    status: tuple[Status, ...]
    """(k,)."""
    combinations: tuple[Combination, ...]


def identifiability(gram: Floats, parameters: Sequence[Parameter]) -> Identifiability:
    """Analyse `gram` (k, k), the products of the regressor's columns summed over all samples."""
    length = np.sqrt(np.diag(gram))
    squares, directions = np.linalg.eigh(gram / np.outer(length, length))
    singular = np.sqrt(np.maximum(squares, 0.0))[::-1]
    directions = directions[:, ::-1]
    index = singular[0] / np.maximum(singular, _ROUNDING * singular[0])
    contributions = (directions * index) ** 2
    shares = contributions / contributions.sum(axis=1, keepdims=True)
    weak, unidentifiable = shares[:, index >= WEAK].sum(axis=1), shares[:, index >= UNIDENTIFIABLE].sum(axis=1)
    status = tuple(_status(*shares_of_parameter) for shares_of_parameter in zip(weak, unidentifiable, strict=True))
    combinations = [
        _combination(
            directions[:, i], singular[i], length, parameters, "not" if index[i] >= UNIDENTIFIABLE else "weak"
        )
        for i in np.flatnonzero(index >= WEAK)
    ]
    return Identifiability(float(index[-1]), tuple(singular.tolist()), status, tuple(combinations))


def known_together(names: Sequence[str], correlation: Floats) -> Iterator[str]:
    """Yield which effects a motion hardly distinguishes, from each other or from a parameter of the base model; of
    each two the parameters whose errors correlate most.

    names: of k parameters, behind that of their effect and a dot; correlation: (k, k) of their errors.
    """
    effects = [name.rpartition(".")[0] for name in names]
    largest: dict[tuple[str, str], tuple[float, str]] = {}
    for i, j in combinations(range(len(names)), 2):
        value, pair = correlation[i, j], (effects[i] or names[i], effects[j])
        least = max(_MAX_CORRELATION if effects[i] else _IMITATION, largest.get(pair, (0.0, ""))[0])
        if effects[j] and effects[i] != effects[j] and abs(value) > least:
            so = (
                "one of the two effects may be all there is"
                if effects[i]
                else "what one has too much, the other lacks"
            )
            sentence = (
                f"{names[i]} and {names[j]} are known only together: this motion hardly distinguishes them (their "
                f"errors correlate by {value:+.2f}), so {so}."
            )
            largest[pair] = abs(value), sentence
    yield from (sentence for _, sentence in largest.values())


def _status(weak: float, unidentifiable: float) -> Status:
    if unidentifiable >= _AFFECTED_SHARE:
        return "not"
    return "weak" if weak >= _AFFECTED_SHARE else "identifiable"


def _combination(
    direction: Floats,
    singular: float,
    length: Floats,
    parameters: Sequence[Parameter],
    status: Literal["weak", "not"],
) -> Combination:
    order = [
        int(i) for i in np.argsort(-np.abs(direction)) if abs(direction[i]) >= _MEMBER_SHARE * np.abs(direction).max()
    ]
    step = direction / length
    step = step / step[order[0]]
    changes = [f"{parameters[i].name} by {step[i]:+.3g} {parameters[i].unit}" for i in order]
    share = float(singular / np.abs(direction).max())
    names = tuple(parameters[i].name for i in order)
    effect = "next to nothing" if status == "not" else f"only {100 * share:.2g} % of what {names[0]} alone would do"
    known = "cannot be told apart" if status == "not" else "can hardly be told apart"
    sentence = f"{', '.join(names)} {known} by this motion: {' and '.join(changes)} together do {effect}"
    return Combination(names, status, sentence)
