"""Has a series changed, when, and suddenly or slowly: evidence that stays valid when it is looked at every night.

Null hypothesis: night t has y_t = mean of its motion + slope * temperature + scatter, with normal scatter of unknown
size. Alternative: from night j on a step, or a ramp, is added. The ratio of the likelihoods with right Haar priors of
mean, slope and size, and a normal prior of the change in units of the scatter, is for every j a martingale under the
null hypothesis (Lai 1976; Perez-Ortiz et al., E-statistics, group invariance and anytime valid testing, 2024), and so
is its mean over all j with fixed weights: an e-process, with expectation at most 1 at any night that one stops at.
Whoever looks every night does not stop: the largest value so far is lowered so that it is an e-value all the same
(Dawid et al., Insuring against loss of evidence, 2011), and an alarm stays one even if the next event hides it. Only
evidence that holds for three nights counts: an odd night, which a normal scatter would not have, is forgotten again.

What the columns of the null hypothesis explain - another motion since night j, or warmer nights - is no evidence.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from pydantic import PlainSerializer, PlainValidator

from ident.basics.statistics import LEVEL
from recordings.recording import Floats, Ints

MIN_BEFORE = 5
"""Nights before a change: a baseline."""
MIN_SUDDEN, MIN_GROWING = 3, 5
"""Nights since a change that an alarm needs: a single odd night is none."""
_SIZES = (9.0, 400.0)
"""Prior variances of a change in units of the scatter's: changes of about 3 and of about 20 standard deviations."""
_RAMP_DAYS = 10.0
"""Days in which a ramp grows by one unit."""
LONGEST = 100
"""Nights for which a change is searched; an older one was found before."""
_ROUNDING = 1e-10
_SIGNIFICANT = 1.64
_MIN_TEMPERING = 0.2
"""The least power to which evidence is raised because nights resemble each other."""


def _matrix(rows: Sequence[Sequence[float]]) -> Floats:
    return np.array(rows, float) if len(rows) else np.zeros((0, 0))


Matrix = Annotated[Floats, PlainValidator(_matrix), PlainSerializer(lambda matrix: matrix.tolist())]
"""Rows of numbers, as lists in a file."""


@dataclass(frozen=True)
class Change:
    """Evidence of a change in one series, and the best description of it."""

    log_e: float
    """Logarithm of the e-value."""
    growing: bool
    index: int
    """Most probable first night with the change."""
    first: int
    """95 % interval of it."""
    last: int
    seen: int
    """Number of nights by which the evidence was largest: later ones may show another change."""
    size: float
    """Height of the step, or what a ramp had reached by then, in units of the series."""
    size_std: float


@dataclass(eq=False)
class ChangeProcess:
    """Evidence of a change in one series, night by night: what a night costs does not grow with their number.

    Steps and ramps begin in the last nights only, and are 0 before. Of earlier nights a triangular factor is kept
    that has the same scalar products, which are all that a likelihood needs.
    """

    count: int = 0
    """Number of nights."""
    window: Matrix = field(default_factory=lambda: _matrix(()))
    """(w, k + 2) day, y and nuisance of the last nights, one more than those in which a change may begin."""
    factor: Matrix = field(default_factory=lambda: _matrix(()))
    """(r, k + 1) triangular factor of y and nuisance of the nights before."""
    tonight: list[float] = field(default_factory=list)
    """Logarithm of the evidence in the last nights."""
    largest: float = -sys.float_info.max
    """Logarithm of the largest evidence that has lasted."""

    def observe(self, y: float, day: float, nuisance: Sequence[float]) -> Change | None:
        """Take the next night; return the change if there was never more evidence that has lasted.

        nuisance: (k,) what may explain any change; where other nights have more, the others are 0.
        """
        self.window = _stacked(self.window, np.array([[day, y, *nuisance]]))
        self.count += 1
        if len(self.window) > LONGEST + 1:
            before = _stacked(self.factor, self.window[:1, 1:])
            self.factor, self.window = np.asarray(np.linalg.qr(before, mode="r")), self.window[1:]
        return self._looked() if self.count > MIN_BEFORE else None

    def _looked(self) -> Change | None:
        rows, days = _stacked(self.factor, self.window[:, 1:]), self.window[:, 0]
        y, nuisance = rows[:, 0], rows[:, 1:]
        before = self.count - len(days)
        begin = np.arange(max(MIN_BEFORE - before, len(days) - LONGEST), len(days))
        columns = np.vstack([np.zeros((len(self.factor), 2, len(begin))), alternatives(days, begin)])
        factors = log_bayes_factors(y, nuisance, columns.reshape(len(y), -1), self.count).reshape(2, -1)
        number = before + begin - MIN_BEFORE
        log_prior = -np.log((number + 1) * (number + 2))  # sums to 1 over all nights to come
        mixed = np.logaddexp.reduce(log_prior + np.logaddexp(*factors) - np.log(2))
        self.tonight.append(float(np.logaddexp(mixed, -np.log(self.count - MIN_BEFORE + 1))))
        del self.tonight[:-MIN_SUDDEN]
        lasting = min(self.tonight)
        if len(self.tonight) < MIN_SUDDEN or lasting < self.largest:
            return None
        self.largest = lasting
        first = before + int(begin[0])
        return _described(y, nuisance, columns, factors, first, lasting, self.count, len(days))


def change(y: Floats, day: Floats, nuisance: Floats) -> Change | None:
    """Evidence of a change in `y` (n,), or None if there are too few nights.

    day: (n,) days, ascending. nuisance: (n, k) columns that may explain any change.
    """
    process, result = ChangeProcess(), None
    for night in zip(y.tolist(), day.tolist(), nuisance.tolist(), strict=True):
        result = process.observe(*night) or result
    return result


def alternatives(day: Floats, begin: Ints) -> Floats:
    """(n, 2, b) step and ramp that begin with each of the nights `begin` (b,), at least 1."""
    since = np.arange(len(day))[:, None] >= begin
    ramp = np.where(since, (day[:, None] - day[begin - 1]) / _RAMP_DAYS, 0.0)
    return np.stack([since.astype(float), ramp], axis=1)


def log_bayes_factors(y: Floats, nuisance: Floats, columns: Floats, nights: int) -> Floats:
    """(c,) logarithm of the likelihood ratio of each of `columns` (t, c) beside the `nuisance` (t, k).

    nights: their number; t rows have the same scalar products.
    """
    basis, rank = _basis(nuisance)
    rest_y, rest = y - basis @ (basis.T @ y), columns - basis @ (basis.T @ columns)
    total, power = float(rest_y @ rest_y), (rest**2).sum(axis=0)
    freedom = nights - rank
    shown = power > _ROUNDING * (columns**2).sum(axis=0)
    if freedom < 1 or total <= _ROUNDING**2 * float(y @ y) or not shown.any():
        return np.zeros(columns.shape[1])
    share = np.where(shown, (rest.T @ rest_y) ** 2 / np.where(shown, power, 1.0) / total, 0.0)
    share = np.minimum(share, 1 - _ROUNDING)
    logs = [-0.5 * np.log1p(g * power) - freedom / 2 * np.log1p(-g * power / (1 + g * power) * share) for g in _SIZES]
    factors: Floats = np.logaddexp(*logs) - np.log(len(_SIZES))
    return np.where(shown, factors, 0.0)


def log_kept(log_m: float) -> float:
    """Logarithm of the e-value that is left of the largest value exp(log_m) of an e-process: (1 - m + m log m) /
    (log m)^2."""
    if log_m < 1e-3:
        return float(-np.log(2))
    return float(log_m + np.log(log_m - 1 + np.exp(-log_m)) - 2 * np.log(log_m))


def _stacked(above: Floats, below: Floats) -> Floats:
    """Rows of both; the columns that either lacks are 0."""
    width = max(above.shape[1], below.shape[1])
    return np.vstack([np.pad(rows, ((0, 0), (0, width - rows.shape[1]))) for rows in (above, below)])


def _basis(nuisance: Floats) -> tuple[Floats, int]:
    """Orthonormal basis (t, r) of the columns, and its rank r."""
    size = np.sqrt((nuisance**2).sum(axis=0))
    vectors, values, _ = np.linalg.svd(nuisance[:, size > 0] / size[size > 0], full_matrices=False)
    rank = int((values > 1e-8 * values.max(initial=0.0)).sum())
    return vectors[:, :rank], rank


def _described(
    y: Floats,
    nuisance: Floats,
    columns: Floats,
    factors: Floats,
    offset: int,
    log_m: float,
    nights: int,
    recent: int,
) -> Change:
    """The change that the Bayes `factors` (2, b) at the last of these nights make most probable.

    columns: (t, 2, b) of changes since the night `offset` and later; log_m: largest value that lasted; recent: number
    of the last rows that are nights themselves.
    """
    weights = np.exp(factors - factors.max())
    growing = bool(weights[1].sum() > weights[0].sum())
    kind = int(growing)
    probability = weights[kind] / weights[kind].sum()
    cumulated = probability.cumsum()
    tail = (1 - LEVEL) / 2
    first, last = np.searchsorted(cumulated, (tail, 1 - tail))
    # Where a motion of its own or a warmer night leaves it open, the first night that shows it.
    best = int(np.flatnonzero(probability >= (1 - 1e-6) * probability.max())[-1])
    design = np.column_stack([nuisance, columns[:, kind, best]])
    size, std, residual = _least_squares(y, design, nights)
    tempering = _tempering(residual[-recent:])
    reached = float(columns[-1, kind, best])
    return Change(
        tempering * log_kept(log_m),
        growing,
        offset + best,
        offset + min(int(first), best),
        offset + max(min(int(last), len(probability) - 1), best),
        nights,
        size * reached,
        std * reached,
    )


def _least_squares(y: Floats, design: Floats, nights: int) -> tuple[float, float, Floats]:
    """Coefficient of the last column of `design`, its standard error, and the residual (n,)."""
    inverse = np.linalg.pinv(design)
    solution = inverse @ y
    residual = y - design @ solution
    freedom = max(nights - np.linalg.matrix_rank(design), 1)
    std = np.sqrt(float(residual @ residual) / freedom * float(inverse[-1] @ inverse[-1]))
    return float(solution[-1]), float(std), residual


def _tempering(residual: Floats) -> float:
    """Power of the evidence if nights resemble those before: by how much n such nights tell less than n others."""
    total = float(residual @ residual)
    n = len(residual)
    correlation = float(residual[1:] @ residual[:-1]) / total if total else 0.0
    if correlation < _SIGNIFICANT / np.sqrt(n):
        return 1.0
    return max((1 - correlation) / (1 + correlation), _MIN_TEMPERING)
