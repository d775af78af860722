"""Choose the joints of an effect from the products of its columns with the residual, by linear algebra."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain, combinations

import numpy as np

from ident.basics.statistics import nonzero
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
        """Reduction of the loss by the instances in `subset`, -inf if one has a wrong sign; and their coefficients.

        Where several coefficients have a sign, those that would get the wrong one are zero: friction of a gear that
        loses nothing in one direction has two of them, and noise decides the sign of the second.
        """
        c = len(self.one_signed)
        own = np.concatenate([np.arange(instance * c, instance * c + c) for instance in subset])
        kept = np.delete(self.replaced, list(subset)) if len(self.replaced) else self.replaced
        entries, signs = np.concatenate([own, kept]), np.tile(self.one_signed, len(subset))
        size = nonzero(np.sqrt(np.diag(self.gram)[entries]))
        scaled, target = self.gram[np.ix_(entries, entries)] / np.outer(size, size), self.correlation[entries] / size
        solution, free = np.zeros(len(entries)), np.ones(len(entries), bool)
        while free.any():
            solution[free] = np.linalg.lstsq(scaled[np.ix_(free, free)], target[free], rcond=1e-9)[0]
            wrong = np.flatnonzero(solution[: len(own)] * signs < 0)
            if not len(wrong):
                break
            solution[wrong], free[wrong] = 0.0, False
        coefficients = solution[: len(own)] / size[: len(own)]
        signed = np.reshape(coefficients * signs, (-1, c))
        if self.one_signed.any() and not (signed > 0).any(axis=1).all():
            return -np.inf, coefficients
        return float(solution @ target) - self.increase, coefficients


def choose_joints(products: Products, instances: Sequence[int]) -> tuple[tuple[int, ...], float, Floats] | None:
    """The smallest subset of `instances` to which no further joint would add much; None if each has a wrong sign.

    Returns it with the reduction of the loss and the coefficients (len(subset) * c,) of its columns.
    """
    few = len(instances) <= _MAX_SUBSET_JOINTS  # of many, each alone and all together
    sizes = range(1, len(instances) + 1) if few else (1, len(instances))
    subsets = chain.from_iterable(combinations(instances, size) for size in sizes)
    tried = [(subset, *products.reduction(subset)) for subset in subsets]
    possible = [each for each in tried if each[1] > 0]
    price = MIN_JOINT_SHARE * max((reduction for _, reduction, _ in possible), default=0.0)
    return min(possible, key=lambda each: price * len(each[0]) - each[1], default=None)
