"""The noise floor: the error that a correct model reaches."""

import numpy as np
import pytest

from ident.diagnosis.split.noise_floor import NoiseFloor, estimate_noise_floor
from ident.diagnosis.split.split_data import SplitData, rms
from recordings.recording import Recording
from tests.ident import building

IN_BAND = np.sqrt(2 * building.CUTOFF / building.RATE)
"""Amplitude ratio of white noise that the low-pass leaves."""


def floor_of(*recordings: Recording, effects: tuple[str, ...] = ()) -> tuple[NoiseFloor, SplitData]:
    data = building.split(recordings)
    model = building.fitted(data, *effects)
    return estimate_noise_floor(data, model.solution, model.residuals), data


def test_noise_is_what_differs_between_cycles() -> None:
    floor, _ = floor_of(building.record(2, 8, noise=0.1, extra=lambda motion: 0.3 * np.sin(9 * motion.position)))
    np.testing.assert_allclose(floor.noise, 0.1 * IN_BAND, rtol=0.1)
    assert floor.lines == floor.trends == (None, None)
    np.testing.assert_allclose(floor.rms, np.hypot(floor.noise, floor.quantization))


@pytest.mark.parametrize("seed", range(20))
def test_interval_of_a_single_cycle_holds_the_noise_whatever_is_missing(seed: int) -> None:
    size = 0.1 * seed
    ripple = building.record(cycles=1, noise=0.1, seed=seed, extra=lambda motion: size * np.cos(5 * motion.position))
    floor, _ = floor_of(ripple)
    assert floor.source == "spectrum"
    assert floor.trends == (None,)
    low, high = floor.ci95[0]
    assert low < np.hypot(0.1 * IN_BAND, floor.quantization[0]) < high < floor.limit[0]


def test_repetitions_of_the_training_motion_suffice() -> None:
    data = building.split([building.record(cycles=5, noise=0.1)], [building.record(cycles=1, noise=0.1, shape=1)])
    model = building.fitted(data)
    floor = estimate_noise_floor(data, model.solution, model.residuals)
    assert floor.source == "repetition"
    np.testing.assert_allclose(floor.noise, 0.1 * IN_BAND, rtol=0.1)


@pytest.mark.parametrize("instant", [0.3, 0.5, 0.6])
def test_load_that_is_picked_up_is_no_noise(instant: float) -> None:
    """Twenty times the noise, at instants of the recording of five cycles."""
    recording = building.record(cycles=5, noise=0.05)
    assert recording.effort is not None
    after = recording.time >= instant * recording.time[-1]
    recording.effort[:] += np.where(after, np.sin(3 * building.motion_of(cycles=5).position[:, 0]), 0.0)[:, None]
    floor, _ = floor_of(recording)
    np.testing.assert_allclose(floor.noise, 0.05 * IN_BAND, rtol=0.3)
    (trend,) = floor.trends
    assert trend is not None
    assert trend.pattern == ("step after 3" if instant == 0.6 else f"step in cycle {int(5 * instant) + 1}")
    assert floor.lines == (None,)


def test_floor_scales_with_the_noise() -> None:
    floors = [floor_of(building.record(cycles=6, noise=size))[0].noise[0] for size in (0.05, 0.2)]
    assert floors[1] / floors[0] == pytest.approx(4.0, rel=0.02)


def test_vibration_is_no_noise() -> None:
    """Of 7.37 Hz, so that it is not in phase with the cycles of 2 s."""
    vibration = building.record(cycles=10, noise=0.05)
    assert vibration.effort is not None
    vibration.effort[:] += 0.2 * np.sin(2 * np.pi * 7.37 * vibration.time)[:, None]
    floor, _ = floor_of(vibration)
    (line,) = floor.lines
    assert line is not None
    assert line.frequency == pytest.approx(7.37, abs=0.05)
    assert floor.noise[0] < 0.5 * 0.2 / np.sqrt(2)


def test_steady_change_is_a_trend_and_no_noise() -> None:
    warming = building.record(cycles=8, noise=0.05)
    assert warming.effort is not None
    direction = np.sign(building.motion_of(cycles=8).velocity)
    warming.effort[:] += 0.5 * direction * (warming.time / warming.time[-1])[:, None]
    floor, _ = floor_of(warming)
    (trend,) = floor.trends
    assert trend is not None
    assert trend.pattern == "linear"
    # Steps of the trend inside of a cycle remain.
    assert floor.noise[0] < 2.5 * 0.05 * IN_BAND


@pytest.mark.parametrize("step", [3e-5, 1e-4])
def test_correct_model_reaches_the_floor_with_coarse_encoders(step: float) -> None:
    """For steps with which this cut-off would be chosen, or one that is not much lower."""
    recording = building.record(cycles=6, noise=0.02, encoder_step=step)
    data = building.split([recording])
    model = building.fitted(data)
    floor = estimate_noise_floor(data, model.solution, model.residuals)
    error = rms(model.residuals, data.scored)
    np.testing.assert_array_less(error, 1.25 * floor.rms)
    np.testing.assert_array_less(floor.rms, 2.5 * error)


def test_finer_encoder_lowers_the_encoder_part() -> None:
    coarse, fine = (floor_of(building.record(noise=0.02, encoder_step=step))[0] for step in (4e-4, 1e-5))
    assert fine.quantization[0] < 0.2 * coarse.quantization[0]


def test_floor_does_not_depend_on_the_order_of_recordings() -> None:
    recordings = [building.record(2, cycles, noise=0.1, seed=cycles) for cycles in (3, 5)]
    forwards, backwards = floor_of(*recordings)[0], floor_of(*reversed(recordings))[0]
    np.testing.assert_allclose(backwards.rms, forwards.rms, rtol=1e-6)
