"""Evidence against a range: rare by chance whenever one looks, even where samples resemble the one before."""

import numpy as np
import pytest
from scipy.signal import lfilter

from ident.sequential.ranges import RangeEvidence
from ident.watch.baseline import block_std
from recordings.recording import Floats

TRIALS, PLACES, HEALTHY, WATCHED = 1500, 4, 20, 60
ROWS = 120
"""Rows of a block: three correlation times."""
CORRELATION = 0.95
"""From row to row."""
EDGE = 0.5
"""Edges of the range, in standard deviations of a block."""


def block_means(cycles: int, seed: int) -> Floats:
    """(cycles, places, trials) of an autoregressive residual."""
    white = np.random.default_rng(seed).normal(size=(TRIALS, cycles * PLACES * ROWS))
    rows = lfilter([np.sqrt(1 - CORRELATION**2)], [1, -CORRELATION], white, axis=1)
    return rows.reshape(TRIALS, cycles, PLACES, ROWS).mean(axis=3).transpose(1, 2, 0)


def observed(means: Floats, std: Floats, true_std: float) -> tuple[Floats, Floats]:
    """(trials,) mean e-value at the end, and the largest one on the way; each trial is a joint."""
    edge = np.full(std.shape, EDGE * true_std)
    evidence = RangeEvidence(-edge, edge, std)
    forward, everything = np.ones(TRIALS, np.int64), np.ones(TRIALS, bool)
    largest = np.zeros(TRIALS)
    for cycle in means:
        for place, mean in enumerate(cycle):
            evidence.observe(place, mean, everything, forward)
        largest = np.maximum(largest, np.exp(evidence.log_e).mean(axis=(1, 2)))
    return np.exp(evidence.log_e).mean(axis=(1, 2)), largest


@pytest.mark.slow
@pytest.mark.parametrize("mean", [0.0, EDGE])
def test_mean_of_e_values_is_at_most_one_on_correlated_residuals(mean: float) -> None:
    """Also for the worst mean that the null hypothesis allows: at the edge of the range."""
    healthy, watched = block_means(HEALTHY, 1), block_means(WATCHED, 2)
    true_std = float(healthy.std())
    e, largest = observed(watched + mean * true_std, block_std(healthy), true_std)
    assert e.mean() <= 1 + 2 * e.std() / np.sqrt(TRIALS)
    assert e.std() > 0
    assert (largest >= 100).mean() <= 0.01


def test_mean_outside_the_range_gives_evidence() -> None:
    healthy, watched = block_means(HEALTHY, 3), block_means(WATCHED, 4)
    true_std = float(healthy.std())
    e, _ = observed(watched + 3 * true_std, block_std(healthy), true_std)
    assert (e > 100).mean() > 0.99
