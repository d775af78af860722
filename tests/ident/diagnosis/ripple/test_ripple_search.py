"""Search of waves over the angle and over time."""

import numpy as np
import pytest

from ident.diagnosis.ripple.high_band import high_bands
from ident.diagnosis.ripple.ripple_search import Waves, search
from ident.diagnosis.ripple.waves import JointSignal
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from tests.ident import building

RATE = 500.0
ENCODER_STEP = 1e-6


def _waves(extra: building.Torque, seed: int = 0, noise: float = 0.2, step: float = ENCODER_STEP) -> Waves:
    recording = building.record(extra=extra, noise=noise, seed=seed, rate=RATE)
    model = building.fitted(building.split([recording]))
    return search(JointSignal(high_bands(model.split, model.solution), 0), step)


def _over_angle(motion: Motion) -> Floats:
    return 0.2 * np.sin(160.0 * motion.position) + 0.15 * np.cos(200.0 * motion.position)


def _over_time(motion: Motion) -> Floats:
    return 0.2 * np.sin(2 * np.pi * 50.0 * np.arange(len(motion.position)) / RATE)[:, None] + 0 * motion.position


def test_waves_over_the_angle_are_found_with_amplitude_and_interval() -> None:
    waves = _waves(_over_angle)
    assert len(waves.orders) == 2
    for order, amplitude, number in ((160.0, 0.2, 0), (200.0, 0.15, 1)):
        assert abs(waves.orders[number] - order) < 2 * waves.half_widths[number, 2] < 0.3
        assert np.hypot(*waves.amplitudes[number]) == pytest.approx(amplitude, rel=0.2)
    assert np.isnan(waves.same_frequency).all()  # the speed varies
    assert len(waves.frequencies) == 0


def test_a_wave_over_time_is_a_vibration_and_no_ripple() -> None:
    waves = _waves(_over_time)
    assert len(waves.orders) == 0
    assert waves.frequencies == pytest.approx([50.0], abs=0.05)
    assert waves.vibrations == pytest.approx([0.2], rel=0.1)


@pytest.mark.parametrize("seed", range(10))
def test_noise_has_no_waves(seed: int) -> None:
    waves = _waves(lambda motion: 0 * motion.position, seed)
    assert len(waves.orders) == len(waves.frequencies) == 0


def test_waves_of_the_size_of_encoder_steps_are_not_searched() -> None:
    assert len(_waves(_over_angle, step=1 / 100).orders) == 0


@pytest.mark.slow
def test_interval_of_the_order_covers_the_truth() -> None:
    inside = 0
    for seed in range(60):
        waves = _waves(lambda motion: 0.1 * np.sin(160.0 * motion.position), seed)
        inside += abs(waves.orders[0] - 160.0) < waves.half_widths[0, 2]
    assert 52 <= inside <= 60  # 95 % of 60, within chance of 1 in 1000
