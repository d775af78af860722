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

from dataclasses import dataclass

import numpy as np

from ident.basics.statistics import LEVEL
from recordings.recording import Floats

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


@dataclass(frozen=True, eq=False)
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


def change(y: Floats, day: Floats, nuisance: Floats) -> Change | None:
    """Evidence of a change in `y` (n,), or None if there are too few nights.

    day: (n,) days, ascending. nuisance: (n, k) columns that may explain any change.
    """
    n = len(y)
    if n < MIN_BEFORE + MIN_SUDDEN:
        return None
    columns = alternatives(day)
    count = n - MIN_BEFORE
    log_prior = -np.log(np.arange(1, count + 1) * np.arange(2, count + 2))  # sums to 1 over all nights to come
    tonight: list[float] = []
    factors: list[Floats] = []
    for t in range(MIN_BEFORE + 1, n + 1):
        begun = t - MIN_BEFORE
        part = slice(max(0, begun - LONGEST), begun)
        of_night = log_bayes_factors(y[:t], nuisance[:t], columns[:t, :, part].reshape(t, -1)).reshape(2, -1)
        mixed = log_prior[part] + np.logaddexp(*of_night) - np.log(2)
        tonight.append(float(np.logaddexp(np.logaddexp.reduce(mixed), -np.log(begun + 1))))
        factors.append(of_night)
    lasting = np.min([tonight[shift : len(tonight) - MIN_SUDDEN + 1 + shift] for shift in range(MIN_SUDDEN)], axis=0)
    last = len(lasting) - 1 - int(lasting[::-1].argmax()) + MIN_SUDDEN - 1
    seen = MIN_BEFORE + 1 + last  # nights until the evidence was largest
    oldest = last + 1 - factors[last].shape[1]
    return _described(
        y[:seen],
        nuisance[:seen],
        columns[:seen, :, oldest:],
        factors[last],
        MIN_BEFORE + oldest,
        float(lasting.max()),
    )


def alternatives(day: Floats) -> Floats:
    """(n, 2, n - MIN_BEFORE) step and ramp that begin with each night."""
    n = len(day)
    begin = np.arange(MIN_BEFORE, n)
    since = np.arange(n)[:, None] >= begin
    ramp = np.where(since, (day[:, None] - day[begin - 1]) / _RAMP_DAYS, 0.0)
    return np.stack([since.astype(float), ramp], axis=1)


def log_bayes_factors(y: Floats, nuisance: Floats, columns: Floats) -> Floats:
    """(c,) logarithm of the likelihood ratio of each of `columns` (t, c) beside the `nuisance` (t, k)."""
    basis, rank = _basis(nuisance)
    rest_y, rest = y - basis @ (basis.T @ y), columns - basis @ (basis.T @ columns)
    total, power = float(rest_y @ rest_y), (rest**2).sum(axis=0)
    freedom = len(y) - rank
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


def _basis(nuisance: Floats) -> tuple[Floats, int]:
    """Orthonormal basis (t, r) of the columns, and its rank r."""
    size = np.sqrt((nuisance**2).sum(axis=0))
    vectors, values, _ = np.linalg.svd(nuisance[:, size > 0] / size[size > 0], full_matrices=False)
    rank = int((values > 1e-8 * values.max(initial=0.0)).sum())
    return vectors[:, :rank], rank


def _described(y: Floats, nuisance: Floats, columns: Floats, factors: Floats, offset: int, log_m: float) -> Change:
    """The change that the Bayes `factors` (2, nights) at the last of these nights make most probable.

    columns: (n, 2, nights or more) of changes since the night `offset` and later; log_m: largest value that lasted.
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
    size, std, residual = _least_squares(y, design)
    tempering = _tempering(residual)
    reached = float(columns[-1, kind, best])
    return Change(
        tempering * log_kept(log_m),
        growing,
        offset + best,
        offset + min(int(first), best),
        offset + max(min(int(last), len(probability) - 1), best),
        len(y),
        size * reached,
        std * reached,
    )


def _least_squares(y: Floats, design: Floats) -> tuple[float, float, Floats]:
    """Coefficient of the last column of `design`, its standard error, and the residual (n,)."""
    inverse = np.linalg.pinv(design)
    solution = inverse @ y
    residual = y - design @ solution
    freedom = max(len(y) - np.linalg.matrix_rank(design), 1)
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
