"""Stribeck friction over samples of some length."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from ident.dynamics.effects.library.stribeck import columns
from ident.dynamics.motion import Motion
from recordings.recording import Floats

SPEED, ACCELERATION = 0.2, 30.0


def _columns(motion: Motion) -> Floats:
    inputs: Any = SimpleNamespace(motion=motion)
    return columns(inputs, {"v_s": SPEED})[:, :, 0]


def _motion(velocity: Floats, sample_time: float) -> Motion:
    """Uniform acceleration through standstill."""
    acceleration = np.full_like(velocity, ACCELERATION)
    half = ACCELERATION * sample_time / 2
    direction = np.clip(velocity / half, -1.0, 1.0) if half else np.sign(velocity)
    return Motion(velocity, velocity, acceleration, direction, sample_time)


def test_column_is_the_mean_over_a_sample() -> None:
    velocity, sample_time = np.linspace(-0.6, 0.6, 61)[:, None], 0.01
    within = np.linspace(-0.5, 0.5, 20_001) * sample_time
    instants = velocity + ACCELERATION * within
    expected = np.mean(np.exp(-((instants / SPEED) ** 2)) * np.sign(instants), axis=1)
    actual = _columns(_motion(velocity, sample_time))[:, 0]
    np.testing.assert_allclose(actual, expected, atol=1e-4)
    assert np.abs(actual - _columns(_motion(velocity, 0.0))[:, 0]).max() > 0.1


def test_short_sample_is_an_instant() -> None:
    velocity = np.linspace(-0.61, 0.6, 60)[:, None]
    instant = _columns(_motion(velocity, 0.0))
    np.testing.assert_allclose(instant, np.exp(-((velocity / SPEED) ** 2)) * np.sign(velocity))
    for sample_time in (1e-7, 1e-5):  # below and above the limit
        np.testing.assert_allclose(_columns(_motion(velocity, sample_time)), instant, rtol=1e-5)
