"""The noise floor: the error that a correct model reaches."""

import numpy as np
import pytest

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.split.noise_floor import NoiseFloor, estimate_noise_floor
from ident.diagnosis.split.split_data import SplitData, rms
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from ident.dynamics.structure import Term
from recordings.recording import Floats, Recording
from tests.ident import building

IN_BAND = np.sqrt(2 * building.CUTOFF / building.RATE)
"""Amplitude ratio of white noise that the low-pass leaves."""


def floor_of(*recordings: Recording) -> tuple[NoiseFloor, SplitData]:
    data = building.split(recordings)
    return building.fitted(data).noise_floor, data


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


def test_rows_that_are_not_scored_tell_no_noise() -> None:
    """At standstill dry friction may be anything, in each cycle something else."""
    data = building.split([building.record(cycles=8, noise=0.1)])
    model, rng = building.fitted(data), np.random.default_rng(4)
    residuals = [
        np.where(scored, residual, rng.normal(0, 5.0, residual.shape))
        for scored, residual in zip(data.scored, model.residuals, strict=True)
    ]
    assert not all(scored.all() for scored in data.scored)
    floor = estimate_noise_floor(data, model.solution, residuals)
    np.testing.assert_allclose(floor.noise, model.noise_floor.noise, rtol=0.05)


def test_repetitions_of_the_training_motion_suffice() -> None:
    data = building.split([building.record(cycles=5, noise=0.1)], [building.record(cycles=1, noise=0.1, shape=1)])
    floor = building.fitted(data).noise_floor
    assert floor.source == "repetition"
    np.testing.assert_allclose(floor.noise, 0.1 * IN_BAND, rtol=0.1)


def elapsed(motion: Motion) -> Floats:
    """(n, 1) time [s]."""
    return np.arange(len(motion.position))[:, None] / building.RATE


def picked_up(share: float) -> building.Torque:
    """A load, of twenty times the noise, from a `share` of five cycles on."""
    instant = share * 5 * building.PERIOD
    return lambda motion: np.where(elapsed(motion) >= instant, np.sin(3 * motion.position), 0.0)


def vibration(motion: Motion) -> Floats:
    """Of 7.37 Hz, so that it is not in phase with the cycles."""
    return 0.2 * np.sin(2 * np.pi * 7.37 * elapsed(motion))


def warming(motion: Motion) -> Floats:
    return 0.5 * np.sign(motion.velocity) * elapsed(motion) / elapsed(motion)[-1]


@pytest.mark.parametrize(
    ("extra", "cycles", "trend", "line"),
    [
        (picked_up(0.3), 5, "step in cycle 2", None),
        (picked_up(0.5), 5, "step in cycle 3", None),
        (picked_up(0.6), 5, "step after 3", None),
        (vibration, 10, None, 7.37),
    ],
)
def test_what_changes_at_an_instant_or_vibrates_is_no_noise(
    extra: building.Torque, cycles: int, trend: str | None, line: float | None
) -> None:
    floor, _ = floor_of(building.record(cycles=cycles, noise=0.05, extra=extra))
    assert [each and each.pattern for each in floor.trends] == [trend]
    assert [each and each.frequency for each in floor.lines] == [line and pytest.approx(line, abs=0.05)]
    assert 0.7 < floor.noise[0] / (0.05 * IN_BAND) < (2.5 if line else 1.3)


def test_steady_change_is_a_trend_and_no_noise() -> None:
    """Steps of the trend inside of a cycle remain."""
    floor, _ = floor_of(building.record(cycles=8, noise=0.05, extra=warming))
    assert [each and each.pattern for each in floor.trends] == ["linear"]
    assert floor.noise[0] < 2.5 * 0.05 * IN_BAND


@pytest.mark.parametrize("step", [3e-5, 1e-4])
def test_correct_model_reaches_the_floor_with_coarse_encoders(step: float) -> None:
    """For steps with which this cut-off would be chosen, or one that is not much lower."""
    floor, data = floor_of(building.record(cycles=6, noise=0.02, encoder_step=step))
    error = rms(building.fitted(data).residuals, data.scored)
    np.testing.assert_array_less(error, 1.25 * floor.rms)
    np.testing.assert_array_less(floor.rms, 2.5 * error)


def test_finer_encoder_lowers_the_encoder_part() -> None:
    coarse, fine = (floor_of(building.record(noise=0.02, encoder_step=step))[0] for step in (4e-4, 1e-5))
    assert fine.quantization[0] < 0.2 * coarse.quantization[0]


def test_floor_does_not_depend_on_the_order_of_recordings() -> None:
    recordings = [building.record(2, cycles, noise=0.1, seed=cycles) for cycles in (3, 5)]
    forwards, backwards = floor_of(*recordings)[0], floor_of(*reversed(recordings))[0]
    np.testing.assert_allclose(backwards.rms, forwards.rms, rtol=1e-6)


def test_elastic_joint_smooths_what_the_encoder_steps_make_of_the_torque() -> None:
    """Beyond its resonance the motor alone follows the encoder; a stiff one follows as the mechanism does."""
    data = building.split([building.record(noise=0.02, encoder_step=1e-4)])
    for compliance, share in ((0.0, 0.0), (2e-3, 0.5)):
        solution = building.fitted(data).solution
        structure = solution.structure.with_term(Term("joint_elasticity", library()["joint_elasticity"], (0,)))
        x = np.concatenate([solution.x, [compliance, 0.3, 0.3]])
        floor = FittedModel(data, data.at(structure, x)).noise_floor
        assert floor.smoothed[0] == pytest.approx(share * floor.quantization[0] ** 2, rel=0.6, abs=1e-12)
