from dataclasses import replace

import numpy as np
import pytest

from ident.data.dataset import Dataset
from ident.identification.prediction import Prediction
from ident.residuals.curves import BinnedCurve, binned_curves
from recordings.recording import Floats
from tests.ident.residuals.conftest import Planted


def curve(axis: str, *predictions: Prediction, joint: int = 0) -> BinnedCurve:
    (found,) = (one for one in binned_curves(predictions, joint) if one.axis == axis)
    return found


def test_a_residual_over_velocity_is_drawn_as_it_is(planted: Planted, dataset: Dataset, noise: Floats) -> None:
    stribeck = 0.5 * np.exp(-((dataset.motion.velocity / 0.4) ** 2)) * dataset.motion.direction
    found = curve("velocity", planted(stribeck + noise))
    expected = 0.5 * np.exp(-((found.centre / 0.4) ** 2)) * np.sign(found.centre)
    away = abs(found.centre) > 0.3
    np.testing.assert_allclose(found.mean[away], expected[away], atol=0.08)
    usable = np.isfinite(dataset.torque[:, 0])
    share = np.mean(stribeck[usable, 0] ** 2) / np.mean((stribeck + noise)[usable, 0] ** 2)
    # Within the bin that the velocity changes sign in, the residual does so too.
    assert 0.6 * share < found.explained < share
    assert found.explained > 2 * curve("position", planted(stribeck + noise)).explained
    assert found.unit == "rad/s"


def test_bands_hold_the_mean_of_noise_and_nothing_is_explained(planted: Planted, dataset: Dataset) -> None:
    rng = np.random.default_rng(1)
    inside, explained = [], []
    for _ in range(10):
        for found in binned_curves([planted(rng.normal(size=dataset.torque.shape))], 1):
            explained.append(found.explained)
            known = np.isfinite(found.half_width)
            inside.append(abs(found.mean[known]) <= found.half_width[known])
    assert np.concatenate(inside).mean() == pytest.approx(0.95, abs=0.03)
    assert np.mean(explained) < 0.01


def test_a_constant_over_a_stay_in_a_bin_does_not_narrow_the_band(planted: Planted, dataset: Dataset) -> None:
    rng = np.random.default_rng(2)
    slow = np.repeat(rng.normal(size=(len(dataset.time) // 50 + 1, 3)), 50, axis=0)[: len(dataset.time)]
    white = rng.normal(size=slow.shape)
    of_slow, of_white = (np.nanmedian(curve("position", planted(x)).half_width) for x in (slow, white))
    # As if they were independent, samples would give both the same band.
    assert of_slow > 1.5 * of_white


def test_a_change_between_cycles_shows_over_cycle_and_time(planted: Planted, dataset: Dataset, noise: Floats) -> None:
    drift = 0.3 * dataset.repeat[:, None] + noise
    over_cycle = curve("cycle", planted(drift))
    np.testing.assert_array_equal(over_cycle.centre, [1, 2, 3, 4])
    np.testing.assert_allclose(over_cycle.mean, [0, 0.3, 0.6, 0.9], atol=0.03)
    assert over_cycle.explained > 0.9
    assert len(curve("time", planted(drift)).centre) == 4


def test_cycles_of_several_recordings_are_counted_on(planted: Planted, noise: Floats) -> None:
    one = planted(noise)
    assert curve("cycle", one, one).centre.tolist() == [1, 2, 3, 4, 5, 6, 7, 8]
    assert curve("velocity", one, one).samples.sum() == 2 * curve("velocity", one).samples.sum()


def test_the_load_is_the_computed_torque(planted: Planted, dataset: Dataset) -> None:
    found = curve("load", planted(0.1 * np.nan_to_num(dataset.torque)))
    slope = np.polyfit(found.centre, found.mean, 1)[0]
    assert slope == pytest.approx(0.1, rel=0.02)


def test_a_bin_that_was_hardly_visited_has_no_band(planted: Planted, dataset: Dataset, noise: Floats) -> None:
    found = curve("time", not_repeated(planted(noise)))
    assert len(found.centre) == 24
    # Each bin of time is one stay of under half a second.
    assert np.isnan(found.half_width).all()


def not_repeated(prediction: Prediction) -> Prediction:
    """As if the motion did not repeat: bins of time may be short."""
    recording = prediction.dataset.recording
    once = replace(recording, run=recording.run.model_copy(update={"period": 0.0}))
    return replace(prediction, dataset=replace(prediction.dataset, recording=once))
