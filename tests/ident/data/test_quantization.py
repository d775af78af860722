"""Quantization errors of encoders and of the drives' signal."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.data.prepared_recording import PreparedRecording
from ident.data.quantization import drive_errors, resolution, with_encoder_errors
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


@given(step=st.floats(1e-6, 10.0), counts=st.lists(st.integers(-500, 500), min_size=2, unique=True))
def test_resolution_divides_all_readings(step: float, counts: list[int]) -> None:
    readings = step * np.array([*counts, max(counts) + 1], float)
    assert resolution(readings[:, None])[0] == pytest.approx(step)


def test_constant_signal_has_no_resolution() -> None:
    assert resolution(np.full((5, 1), 2.0)).tolist() == [0.0]


def test_encoder_errors_are_at_most_half_a_step_and_differ_between_draws() -> None:
    prepared = building.prepared(building.record(encoder_step=1e-4))
    first, second = (with_encoder_errors(prepared, draw).samples.position for draw in (0, 1))
    assert 0 < np.abs(first - prepared.samples.position).max() <= 0.5e-4 * (1 + 1e-6)
    assert not np.array_equal(first, second)


def test_drive_errors_have_the_size_of_the_real_ones() -> None:
    prepared, torque = _prepared(noise=0.0)
    real = prepared.torque - prepared.condition(torque)
    simulated = np.array([drive_errors(prepared, torque, draw)[0] for draw in range(8)])
    assert np.nanstd(simulated) == pytest.approx(np.nanstd(real), rel=0.25)


def test_drive_errors_without_noise_repeat() -> None:
    prepared, torque = _prepared(noise=0.0)
    pairs = np.array([drive_errors(prepared, torque, draw) for draw in range(8)])
    assert np.nanmean(pairs[:, 0] * pairs[:, 1]) > 0.5 * np.nanmean(pairs**2)


@pytest.mark.parametrize(("noise", "step"), [(STEP, STEP), (0.05, 0.0)])
def test_noise_above_the_steps_leaves_nothing_that_repeats(noise: float, step: float) -> None:
    prepared, torque = _prepared(noise, step)
    assert not np.array(drive_errors(prepared, torque)).any()
