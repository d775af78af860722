"""Variance of weighted sums of autocorrelated noise.

Parzen's lag weights keep variances non-negative. Their bandwidth follows Andrews,
"Heteroskedasticity and autocorrelation consistent covariance matrix estimation", Econometrica 59 (1991), 817-858,
Eqs. (6.2), (6.4), with first-order autoregressions.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from recordings.recording import Floats

Complexes = NDArray[np.complex128]

_BANDWIDTH, _KERNEL_SQUARE = 2.6614, 0.539285
"""Parzen's kernel: constant of the optimal bandwidth, integral of the squared kernel."""
_MAX_AUTOCORRELATION = 0.97
"""Upper limit of the first-order autocorrelation: towards 1 the bandwidth would grow without limit."""


def bandwidth(blocks: Sequence[Floats]) -> float:
    """Andrews' bandwidth [rows] for `blocks` of series (m, s) of equal variance."""
    rows = sum(len(block) for block in blocks)
    largest = np.max([np.abs(block).max(axis=0, initial=0.0) for block in blocks], axis=0)
    # In units of the largest value, because the squares of tiny ones vanish.
    units = [block / np.where(largest > np.finfo(float).tiny, largest, np.inf) for block in blocks]
    products = sum((block[1:] * block[:-1]).sum(axis=0) for block in units)
    squares = sum((block[:-1] ** 2).sum(axis=0) for block in units)
    present = squares > 0
    if not present.any():
        return 1.0
    rho = np.clip(products[present] / squares[present], -_MAX_AUTOCORRELATION, _MAX_AUTOCORRELATION)
    innovation = (1 - rho**2) ** 2
    alpha = np.sum(4 * rho**2 * innovation / (1 - rho) ** 8) / np.sum(innovation / (1 - rho) ** 4)
    return float(np.clip(_BANDWIDTH * (alpha * rows) ** 0.2, 1.0, rows))


def parzen(width: float) -> Floats:
    """Parzen's weights of the lags 0, 1, ... below `width`."""
    share = np.arange(int(np.ceil(width))) / width
    return np.where(share <= 0.5, 1 - 6 * share**2 + 6 * share**3, 2 * (1 - share) ** 3)


def variance_of_sum(blocks: Sequence[Floats]) -> tuple[Floats, Floats]:
    """Covariance (k, k) of the sums of series (m, k) over all `blocks`, and degrees of freedom (k,) of the variances.

    The degrees of freedom follow from the number of rows and the bandwidth.
    """
    rows, series = sum(len(block) for block in blocks), blocks[0].shape[1]
    width = bandwidth(blocks)
    weights = parzen(width)
    total = np.zeros((series, series))
    for block in blocks:
        size = _transform_length(len(block) + len(weights))
        transform = np.fft.rfft(block, size, axis=0)
        smoothed = np.fft.irfft(transform * _spectrum(weights, size)[:, None], size, axis=0)[: len(block)]
        total += block.T @ smoothed
    return (total + total.T) / 2, np.full(series, rows / (width * _KERNEL_SQUARE))


@dataclass(frozen=True, eq=False)
class StationaryNoise:
    """Stationary noise of several joints, described by its autocovariances."""

    covariance: Floats
    """(lags, dof, dof) covariance of joint i with joint j, l rows later, at [l, i, j]; times the lag weights."""
    weights: Floats
    """(lags,) lag weights."""
    samples: Floats
    """(dof,) number of samples."""

    @classmethod
    def estimate(cls, blocks: Sequence[Floats], valid: Sequence[Floats]) -> "StationaryNoise":
        """Estimate from `blocks` of noise (m, dof); `valid` (m, dof) is 1, or 0 where the noise is not known."""
        width = min(bandwidth(blocks), max(len(block) for block in blocks) / 2)
        weights = parzen(width)
        products = sum(_lagged(block, len(weights)) for block in blocks)
        pairs = sum(_lagged(mask, len(weights)) for mask in valid)
        covariance = weights[:, None, None] * np.where(pairs > 0.5, products / np.maximum(pairs, 0.5), 0.0)
        samples = np.sum([mask.sum(axis=0) for mask in valid], axis=0)
        return cls(covariance, weights, samples)

    def variance_of_sums(self, blocks: Iterable[Floats]) -> tuple[Floats, Floats]:
        """Covariance (k, k) of the sums of factor (m, dof, k) times noise over all `blocks`; degrees of freedom (k,).

        Bartlett's formula gives the scatter of each variance due to the estimated autocovariances. The degrees of
        freedom are those of a chi-squared variable with the same relative scatter.
        """
        lags, dof = len(self.weights), self.covariance.shape[1]
        total, autocorrelation = np.zeros((0, 0)), np.zeros((lags, dof, 0))
        for factor in blocks:
            if not autocorrelation.shape[2]:
                total, autocorrelation = np.zeros((factor.shape[2],) * 2), np.zeros((lags, dof, factor.shape[2]))
            size = _transform_length(len(factor) + lags)
            transforms = [np.fft.rfft(factor[:, joint], size, axis=0) for joint in range(dof)]
            for i in range(dof):
                power = np.fft.irfft(np.abs(transforms[i]) ** 2, size, axis=0)
                autocorrelation[:, i] += power[:lags]
                for j in range(dof):
                    cross = _cross_spectrum(self.covariance[:, i, j], self.covariance[:, j, i], size)
                    total += _sums_of_products(transforms[i], cross[:, None] * transforms[j], size)
        return (total + total.T) / 2, self._degrees_of_freedom(autocorrelation)

    def _degrees_of_freedom(self, autocorrelation: Floats) -> Floats:
        """(k,) degrees of freedom; autocorrelation: (lags, dof, k) of the factors of each joint and parameter."""
        variance, scatter = np.zeros(autocorrelation.shape[2]), np.zeros(autocorrelation.shape[2])
        size = _transform_length(2 * len(self.weights))
        for joint, samples in enumerate(self.samples):
            density = _spectrum(self.covariance[:, joint, joint], size)[:, None]
            shape = np.stack(
                [_spectrum(self.weights * column, size) for column in autocorrelation[:, joint].T], axis=1
            )
            variance += _mean(shape * density, size)
            scatter += 2 / samples * _mean((shape * density) ** 2, size)
        freedom: Floats = 2 * variance**2 / np.where(scatter > 0, scatter, np.inf)
        return np.where(freedom > 0, freedom, np.inf)


def _lagged(x: Floats, lags: int) -> Floats:
    """(lags, dof, dof) sums of x[t, i] x[t + l, j] over all rows of `x` (m, dof)."""
    size = _transform_length(len(x) + lags)
    transform = np.fft.rfft(x, size, axis=0)
    return np.fft.irfft(transform[:, :, None].conj() * transform[:, None, :], size, axis=0)[:lags]


def _spectrum(lagged: Floats, size: int) -> Floats:
    """Fourier transform (size // 2 + 1,) of an even sequence, given its lags 0, 1, ..."""
    return 2 * np.fft.rfft(lagged, size).real - lagged[0]


def _cross_spectrum(later: Floats, earlier: Floats, size: int) -> Complexes:
    """Fourier transform of the cross-covariance c with lags 0, 1, ... in `later` and lags 0, -1, ... in `earlier`.

    In the sum over s, t of a[s] c[t - s] b[t] it multiplies the transform of b.
    """
    positive, negative = np.fft.rfft(later, size), np.fft.rfft(earlier, size)
    return positive.conj() + negative - later[0]


def _sums_of_products(a: Complexes, b: Complexes, size: int) -> Floats:
    """(k, k) sums over all rows of the products of two real sequences (rows, k), given their Fourier transforms."""
    weight = _two_sided_weights(len(a), size)[:, None]
    return (a.conj().T @ (weight * b)).real / size


def _mean(spectrum: Floats, size: int) -> Floats:
    """(k,) mean over all `size` frequencies of a real, even spectrum (size // 2 + 1, k)."""
    return _two_sided_weights(len(spectrum), size) @ spectrum / size


def _two_sided_weights(length: int, size: int) -> Floats:
    """Number of occurrences of each frequency of the one-sided transform in the two-sided one."""
    weight = np.full(length, 2.0)
    weight[0] = 1.0
    if size % 2 == 0:
        weight[-1] = 1.0
    return weight


def _transform_length(rows: int) -> int:
    from scipy.fft import next_fast_len

    return int(next_fast_len(rows, real=True))
