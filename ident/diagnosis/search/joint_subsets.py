"""Choose the joints of an effect from the products of its columns with the residual, by linear algebra."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from recordings.recording import Floats, Ints

_MAX_SUBSET_JOINTS = 4
"""Up to this number of joints, all subsets are tried."""
MIN_JOINT_SHARE = 0.03
"""A joint must add this share of the reduction to be included."""


@dataclass(frozen=True, eq=False)
class Products:
    """Products of the columns of an effect, made orthogonal to those of the model beside which it stands."""

    gram: Floats
    """(instances * c + j, instances * c + j); the last columns are those of the j instances that it replaces."""
    correlation: Floats
    """(instances * c + j,) with the residual of the model without the replaced columns."""
    increase: float
    """Of the loss, without the replaced columns."""
    one_signed: Floats
    """(c,) 1 where only a positive coefficient is possible, -1 where only a negative one is, else 0."""
    replaced: Ints
    """(j,) entries of the replaced columns, one of each instance; (0,) if the effect replaces nothing."""

    def reduction(self, subset: Sequence[int]) -> tuple[float, Floats]:
        """Reduction of the loss by the instances in `subset`, -inf if a sign is wrong; and their coefficients."""
        c = len(self.one_signed)
        own = np.concatenate([np.arange(instance * c, instance * c + c) for instance in subset])
        kept = np.delete(self.replaced, list(subset)) if len(self.replaced) else self.replaced
        entries = np.concatenate([own, kept])
        normal_matrix = self.gram[np.ix_(entries, entries)]
        size = np.sqrt(np.diag(normal_matrix))
        size[size == 0] = 1.0
        scaled = normal_matrix / np.outer(size, size)
        solution = np.linalg.lstsq(scaled, self.correlation[entries] / size, rcond=1e-9)[0] / size
        coefficients = solution[: len(own)]
        if (coefficients * np.tile(self.one_signed, len(subset)) < 0).any():
            return -np.inf, coefficients
        return float(solution @ self.correlation[entries]) - self.increase, coefficients


def choose_joints(products: Products, instances: Sequence[int]) -> tuple[tuple[int, ...], float, Floats] | None:
    """The smallest subset of `instances` to which no further joint would add much; None if each has a wrong sign.

    Returns it with the reduction of the loss and the coefficients (len(subset) * c,) of its columns.
    """
    tried = [(subset, *products.reduction(subset)) for subset in _subsets(instances)]
    possible = [each for each in tried if each[1] > 0]
    largest = max((reduction for _, reduction, _ in possible), default=0.0)
    price = MIN_JOINT_SHARE * largest
    return min(possible, key=lambda each: price * len(each[0]) - each[1], default=None)


def _subsets(instances: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """All subsets; with many joints, each alone and all together."""
    if len(instances) <= _MAX_SUBSET_JOINTS:
        for size in range(1, len(instances) + 1):
            yield from combinations(instances, size)
    else:
        yield from ((instance,) for instance in instances)
        yield tuple(instances)
