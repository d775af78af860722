"""Curves and spectra of a residual."""

from dataclasses import replace

import numpy as np
import pytest

from ident.data.prepared_recording import PreparedRecording
from ident.identification.prediction import Prediction
from ident.residuals.curves import BinnedCurve, binned_curves
from ident.residuals.spectrum import spectrum
from recordings.recording import Floats
from tests.ident.residuals.conftest import Planted


def curve(axis: str, *predictions: Prediction, joint: int = 0) -> BinnedCurve:
    (result,) = (candidate for candidate in binned_curves(predictions, joint) if candidate.axis == axis)
    return result


def test_a_residual_that_depends_on_velocity_is_reproduced(
    planted: Planted, prepared: PreparedRecording, noise: Floats
) -> None:
    stribeck = 0.5 * np.exp(-((prepared.motion.velocity / 0.4) ** 2)) * prepared.motion.direction
    binned = curve("velocity", planted(stribeck + noise))
    expected = 0.5 * np.exp(-((binned.centre / 0.4) ** 2)) * np.sign(binned.centre)
    away = abs(binned.centre) > 0.3
    np.testing.assert_allclose(binned.mean[away], expected[away], atol=0.08)
    usable = np.isfinite(prepared.torque[:, 0])
    share = np.mean(stribeck[usable, 0] ** 2) / np.mean((stribeck + noise)[usable, 0] ** 2)
    # In the bin in which the velocity changes sign, the residual changes sign too.
    assert 0.6 * share < binned.explained < share
    assert binned.explained > 2 * curve("position", planted(stribeck + noise)).explained
    assert binned.unit == "rad/s"


def test_bands_cover_the_mean_of_noise_and_nothing_is_explained(
    planted: Planted, prepared: PreparedRecording
) -> None:
    rng = np.random.default_rng(1)
    inside, explained = [], []
    for _ in range(10):
        for binned in binned_curves([planted(rng.normal(size=prepared.torque.shape))], 1):
            explained.append(binned.explained)
            known = np.isfinite(binned.half_width)
            inside.append(abs(binned.mean[known]) <= binned.half_width[known])
    assert np.concatenate(inside).mean() == pytest.approx(0.95, abs=0.03)
    assert np.mean(explained) < 0.01


def test_correlation_within_a_visit_of_a_bin_widens_the_band(planted: Planted, prepared: PreparedRecording) -> None:
    rng = np.random.default_rng(2)
    slow = np.repeat(rng.normal(size=(len(prepared.time) // 50 + 1, 3)), 50, axis=0)[: len(prepared.time)]
    white = rng.normal(size=slow.shape)
    of_slow, of_white = (np.nanmedian(curve("position", planted(x)).half_width) for x in (slow, white))
    # If samples were treated as independent, both bands would be equal.
    assert of_slow > 1.5 * of_white


def test_a_change_between_cycles_shows_over_cycle_and_time(
    planted: Planted, prepared: PreparedRecording, noise: Floats
) -> None:
    drift = 0.3 * prepared.repeat[:, None] + noise
    over_cycle = curve("cycle", planted(drift))
    np.testing.assert_array_equal(over_cycle.centre, [1, 2, 3, 4])
    np.testing.assert_allclose(over_cycle.mean, [0, 0.3, 0.6, 0.9], atol=0.03)
    assert over_cycle.explained > 0.9
    assert len(curve("time", planted(drift)).centre) == 4
    prediction = planted(noise)  # cycles are numbered across recordings
    assert curve("cycle", prediction, prediction).centre.tolist() == [1, 2, 3, 4, 5, 6, 7, 8]
    assert curve("velocity", prediction, prediction).samples.sum() == 2 * curve("velocity", prediction).samples.sum()


def test_the_load_is_the_computed_torque(planted: Planted, prepared: PreparedRecording) -> None:
    binned = curve("load", planted(0.1 * np.nan_to_num(prepared.torque)))
    slope = np.polyfit(binned.centre, binned.mean, 1)[0]
    assert slope == pytest.approx(0.1, rel=0.02)


def test_a_bin_with_too_few_visits_has_no_band(planted: Planted, noise: Floats) -> None:
    """The motion does not repeat: each bin of time is one visit of less than half a second."""
    prediction = planted(noise)
    recording = prediction.prepared.recording
    once = replace(recording, run=recording.run.model_copy(update={"period": 0.0}))
    binned = curve("time", replace(prediction, prepared=replace(prediction.prepared, recording=once)))
    assert len(binned.centre) == 24
    assert np.isnan(binned.half_width).all()


def test_a_vibration_shows_at_its_frequency_with_its_power(planted: Planted, prepared: PreparedRecording) -> None:
    wave = 0.2 * np.sin(2 * np.pi * 12 * prepared.time)[:, None] * [1, 1, 1]
    result = spectrum([planted(wave)], 0)
    assert result.frequency[result.residual.argmax()] == pytest.approx(12, abs=0.3)
    assert result.residual.sum() * (result.frequency[1] - result.frequency[0]) == pytest.approx(0.02, rel=0.1)
    assert result.frequency[-1] <= prepared.bandwidth


def test_the_repeating_part_is_not_noise(planted: Planted, prepared: PreparedRecording, noise: Floats) -> None:
    repeating = np.nan_to_num(np.sin(2 * np.pi * 5 * prepared.phase))[:, None] * [1, 1, 1]
    result = spectrum([planted(repeating + noise)], 0)
    at_five = abs(result.frequency - 5).argmin()
    assert result.residual[at_five] > 20 * result.noise[at_five]
    elsewhere = result.frequency > 10
    assert result.noise[elsewhere].mean() == pytest.approx(result.residual[elsewhere].mean(), rel=0.15)


def test_gaps_and_motions_without_repetition_are_accepted(
    planted: Planted, prepared: PreparedRecording, noise: Floats
) -> None:
    noise[700:705] = np.nan
    samples = replace(prepared.samples, repeat=np.full_like(prepared.samples.repeat, -1))
    not_repeated = replace(planted(noise), prepared=replace(prepared, samples=samples))
    result = spectrum([not_repeated], 2)
    assert result.noise is None
    assert np.isfinite(result.residual).all()
