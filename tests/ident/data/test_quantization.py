"""Quantization errors of encoders and of the drives' signal."""

from dataclasses import replace

import numpy as np
import pytest

from ident.data.prepared_recording import PreparedRecording
from ident.data.quantization import drive_errors, with_encoder_errors
from recordings.recording import Floats
from tests.ident import building

STEP = 0.2
"""Of the measured torque [N m]."""


def _prepared(noise: float, step: float = STEP) -> tuple[PreparedRecording, Floats]:
    """A recording whose torque was read in steps, and the torque before noise and steps (n, dof) [N m]."""
    exact = building.record(cycles=4, drift=0.0)
    assert exact.effort is not None
    noisy = exact.effort + noise * np.random.default_rng(0).normal(size=exact.effort.shape)
    read = step * np.rint(noisy / step) if step else noisy
    return building.prepared(replace(exact, effort=read)), exact.effort


def test_encoder_errors_are_at_most_half_a_step_and_differ_between_draws() -> None:
    prepared = building.prepared(building.record(encoder_step=1e-4))
    first, second = (with_encoder_errors(prepared, draw).samples.position for draw in (0, 1))
    assert 0 < np.abs(first - prepared.samples.position).max() <= 0.5e-4 * (1 + 1e-6)
    assert not np.array_equal(first, second)


def test_drive_errors_have_the_size_of_the_real_ones() -> None:
    prepared, torque = _prepared(noise=0.0)
    real = prepared.torque - prepared.condition(torque)
    simulated = np.array(drive_errors(prepared, torque))[:, 0]
    assert np.nanstd(simulated) == pytest.approx(np.nanstd(real), rel=0.25)


def test_drive_errors_without_noise_repeat() -> None:
    prepared, torque = _prepared(noise=0.0)
    pairs = np.array(drive_errors(prepared, torque))
    assert np.nanmean(pairs[:, 0] * pairs[:, 1]) > 0.5 * np.nanmean(pairs**2)


@pytest.mark.parametrize(("noise", "step"), [(STEP, STEP), (0.05, 0.0)])
def test_noise_above_the_steps_leaves_nothing_that_repeats(noise: float, step: float) -> None:
    prepared, torque = _prepared(noise, step)
    assert not np.array(drive_errors(prepared, torque)).any()
