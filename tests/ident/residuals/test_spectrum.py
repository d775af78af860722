from dataclasses import replace

import numpy as np
import pytest

from ident.data.dataset import Dataset
from ident.residuals.spectrum import spectrum
from recordings.recording import Floats
from tests.ident.residuals.conftest import Planted


def test_a_vibration_shows_at_its_frequency_with_its_power(planted: Planted, dataset: Dataset) -> None:
    wave = 0.2 * np.sin(2 * np.pi * 12 * dataset.time)[:, None] * [1, 1, 1]
    found = spectrum([planted(wave)], 0)
    assert found.frequency[found.residual.argmax()] == pytest.approx(12, abs=0.3)
    assert found.residual.sum() * (found.frequency[1] - found.frequency[0]) == pytest.approx(0.02, rel=0.1)
    assert found.frequency[-1] <= dataset.bandwidth


def test_what_repeats_is_no_noise(planted: Planted, dataset: Dataset, noise: Floats) -> None:
    repeating = np.nan_to_num(np.sin(2 * np.pi * 5 * dataset.phase))[:, None] * [1, 1, 1]
    found = spectrum([planted(repeating + noise)], 0)
    assert found.noise is not None
    at_five = abs(found.frequency - 5).argmin()
    assert found.residual[at_five] > 20 * found.noise[at_five]
    elsewhere = found.frequency > 10
    assert found.noise[elsewhere].mean() == pytest.approx(found.residual[elsewhere].mean(), rel=0.15)


def test_gaps_and_motions_that_do_not_repeat_are_no_obstacle(
    planted: Planted, dataset: Dataset, noise: Floats
) -> None:
    noise[700:705] = np.nan
    once = replace(planted(noise), dataset=replace(dataset, repeat=np.full_like(dataset.repeat, -1)))
    found = spectrum([once], 2)
    assert found.noise is None
    assert np.isfinite(found.residual).all()
