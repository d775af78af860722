"""Search of waves over the angle and over time."""

import numpy as np
import pytest

from ident.diagnosis.ripple.high_band import high_bands
from ident.diagnosis.ripple.lines import RippleLine, Vibration
from ident.diagnosis.ripple.ripple_search import search
from ident.diagnosis.ripple.waves import JointSignal
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from tests.ident import building

RATE = 500.0
ENCODER_STEP = 1e-6


def _waves(
    extra: building.Torque, seed: int = 0, noise: float = 0.2, step: float = ENCODER_STEP
) -> tuple[list[RippleLine], list[Vibration]]:
    recording = building.record(extra=extra, noise=noise, seed=seed, rate=RATE)
    model = building.fitted(building.split([recording]))
    return search(JointSignal(high_bands(model.split, model.solution), 0), step)


def _over_angle(motion: Motion) -> Floats:
    return 0.2 * np.sin(160.0 * motion.position) + 0.15 * np.cos(200.0 * motion.position)


def _over_time(motion: Motion) -> Floats:
    return 0.2 * np.sin(2 * np.pi * 50.0 * np.arange(len(motion.position)) / RATE)[:, None] + 0 * motion.position


def test_waves_over_the_angle_are_found_with_amplitude_and_interval() -> None:
    lines, vibrations = _waves(_over_angle)
    assert len(lines) == 2
    for line, order, amplitude in zip(lines, (160.0, 200.0), (0.2, 0.15), strict=True):
        assert abs(line.order - order) < 2 * line.half_width[2] < 0.3
        assert line.amplitude == pytest.approx(amplitude, rel=0.2)
        assert line.same_frequency is None  # the speed varies
    assert not vibrations


def test_a_wave_over_time_is_a_vibration_and_no_ripple() -> None:
    lines, (vibration,) = _waves(_over_time)
    assert not lines
    assert vibration.frequency == pytest.approx(50.0, abs=0.05)
    assert vibration.amplitude == pytest.approx(0.2, rel=0.1)


@pytest.mark.parametrize("seed", range(10))
def test_noise_has_no_waves(seed: int) -> None:
    assert _waves(lambda motion: 0 * motion.position, seed) == ([], [])


def test_waves_of_the_size_of_encoder_steps_are_not_searched() -> None:
    assert _waves(_over_angle, step=1 / 100)[0] == []


@pytest.mark.slow
def test_interval_of_the_order_covers_the_truth() -> None:
    inside = 0
    for seed in range(60):
        (line, *_), _ = _waves(lambda motion: 0.1 * np.sin(160.0 * motion.position), seed)
        inside += abs(line.order - 160.0) < line.half_width[2]
    assert 52 <= inside <= 60  # 95 % of 60, within chance of 1 in 1000
