"""Choose the joints of an effect from the products of its columns with the residual, by linear algebra."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ident.basics.statistics import nonzero
from recordings.recording import Floats, Ints

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
    """The best of the `instances`, then whichever adds most to them, as long as it adds much; None if none can be.

    Returns them with the reduction of the loss and the coefficients (len(subset) * c,) of their columns.
    """
    chosen: tuple[tuple[int, ...], float, Floats] | None = None
    while True:
        subset, reduction = ((), 0.0) if chosen is None else chosen[:2]
        tried = [tuple(sorted((*subset, each))) for each in instances if each not in subset]
        best = max(((each, *products.reduction(each)) for each in tried), key=lambda each: each[1], default=None)
        if best is None or best[1] - reduction <= MIN_JOINT_SHARE * max(best[1], 0.0):
            return chosen
        chosen = best
