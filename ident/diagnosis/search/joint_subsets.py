"""Choose the joints of an effect from the products of its columns with the residual, by linear algebra."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from recordings.recording import Floats

_MAX_SUBSET_JOINTS = 4
"""Up to this number of joints, all subsets are tried."""
MIN_JOINT_SHARE = 0.03
"""A joint must add this share of the reduction to be included. With a smaller share of the largest squared strength,
it must be confirmed to stay."""


@dataclass(frozen=True, eq=False)
class Replaced:
    """The direction in which each of j columns of the model differs from all others: its dual vector."""

    gram: Floats
    """(j, j) products of the dual vectors."""
    columns: Floats
    """(j, instances * c) their products with the columns of the effect."""
    target: Floats
    """(j,) their products with the residual without these columns."""


@dataclass(frozen=True, eq=False)
class Products:
    """Products of the columns of an effect, made orthogonal to those of the model."""

    gram: Floats
    """(instances * c, instances * c)"""
    correlation: Floats
    """(instances * c,) with the residual."""
    one_signed: Floats
    """(c,) 1 where only a positive coefficient is possible, -1 where only a negative one is, else 0."""
    replaced: Replaced | None = None
    """Columns of the model that the effect replaces, one of each of its instances."""

    def reduction(self, subset: tuple[int, ...]) -> tuple[float, Floats]:
        """Reduction of the loss by the instances in `subset`, -inf if a sign is wrong; and their coefficients."""
        c = len(self.one_signed)
        gram, correlation, increase = self._without_replaced(subset)
        entries = np.concatenate([np.arange(instance * c, instance * c + c) for instance in subset])
        normal_matrix = gram[np.ix_(entries, entries)]
        size = np.sqrt(np.diag(normal_matrix))
        size[size == 0] = 1.0
        coefficients = (
            np.linalg.lstsq(normal_matrix / np.outer(size, size), correlation[entries] / size, rcond=1e-9)[0] / size
        )
        if (coefficients * np.tile(self.one_signed, len(subset)) < 0).any():
            return -np.inf, coefficients
        return float(coefficients @ correlation[entries]) - increase, coefficients

    def _without_replaced(self, subset: tuple[int, ...]) -> tuple[Floats, Floats, float]:
        """Both products and the increase of the loss, without the columns that are replaced on the `subset`."""
        if self.replaced is None:
            return self.gram, self.correlation, 0.0
        joints = list(subset)
        columns, target = self.replaced.columns[joints], self.replaced.target[joints]
        inverse = np.linalg.pinv(self.replaced.gram[np.ix_(joints, joints)])
        return (
            self.gram + columns.T @ inverse @ columns,
            self.correlation + columns.T @ inverse @ target,
            float(target @ inverse @ target),
        )


@dataclass(frozen=True, eq=False)
class ChosenJoints:
    """The instances of an effect that are worth their parameters."""

    subset: tuple[int, ...]
    reduction: float
    """Fall of the weighted sum of squares."""
    coefficients: Floats
    """(len(subset) * c,) of their columns."""


def choose_joints(products: Products, instances: Sequence[int]) -> ChosenJoints | None:
    """The smallest subset of `instances` to which no further joint would add much; None if each has a wrong sign."""
    tried = {subset: products.reduction(subset) for subset in _subsets(instances)}
    best = _parsimonious({subset: reduction for subset, (reduction, _) in tried.items()})
    return None if best is None else ChosenJoints(best, *tried[best])


def _subsets(instances: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """All subsets; with many joints, each alone and all together."""
    if len(instances) <= _MAX_SUBSET_JOINTS:
        for size in range(1, len(instances) + 1):
            yield from combinations(instances, size)
    else:
        yield from ((instance,) for instance in instances)
        yield tuple(instances)


def _parsimonious(reductions: Mapping[tuple[int, ...], float]) -> tuple[int, ...] | None:
    """The smallest subset to which no further joint would add much."""
    possible = {subset: reduction for subset, reduction in reductions.items() if reduction > 0}
    if not possible:
        return None
    largest = max(possible.values())
    return min(possible, key=lambda subset: largest - possible[subset] + MIN_JOINT_SHARE * largest * len(subset))
