"""Drifts and changes at one instant are told from noise and from each other."""

import numpy as np
import pytest

from ident.data.trends import clearest_trend
from recordings.recording import Floats

CYCLES, PHASES = 5, 200
TIME = np.arange(CYCLES)[:, None] + np.arange(PHASES) / PHASES
SHAPE = np.sin(6 * np.pi * TIME + 1)


def noise(seed: int) -> Floats:
    return np.random.default_rng(seed).normal(size=TIME.shape)


@pytest.mark.parametrize("instant", [0.4, 1.0, 1.72, 2.5, 3.31, 4.0, 4.6])
def test_change_at_an_instant_has_its_cycle(instant: float) -> None:
    trend, others = clearest_trend(noise(0) + 3 * SHAPE * (TIME >= instant), 1.0, PHASES) or (None, 0.0)
    assert trend is not None
    assert trend.significant
    whole = instant == round(instant)
    assert trend.pattern == (f"step after {round(instant)}" if whole else f"step in cycle {int(instant) + 1}")
    assert others < 2.0


def test_drift_is_linear() -> None:
    trend, others = clearest_trend(noise(1) + SHAPE * TIME, 1.0, PHASES) or (None, 0.0)
    assert trend is not None
    assert trend.pattern == "linear"
    assert trend.mean_square == pytest.approx(1.0, rel=0.2)  # variance of 0 to 4, times that of the shape
    assert others == pytest.approx(1.0, rel=0.2)


def test_noise_is_rarely_a_trend() -> None:
    trends = [clearest_trend(noise(seed), 1.0, PHASES) for seed in range(200)]
    assert sum(pair[0].significant for pair in trends if pair) <= 3


def test_too_few_cycles_have_no_trend() -> None:
    assert clearest_trend(noise(0)[:2], 1.0, PHASES) is None
    assert clearest_trend(noise(0)[:, :5], 1.0, PHASES) is None
