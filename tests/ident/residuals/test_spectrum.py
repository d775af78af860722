from dataclasses import replace

import numpy as np
import pytest

from ident.data.prepared_recording import PreparedRecording
from ident.residuals.spectrum import spectrum
from recordings.recording import Floats
from tests.ident.residuals.conftest import Planted


def test_a_vibration_shows_at_its_frequency_with_its_power(planted: Planted, prepared: PreparedRecording) -> None:
    wave = 0.2 * np.sin(2 * np.pi * 12 * prepared.time)[:, None] * [1, 1, 1]
    result = spectrum([planted(wave)], 0)
    assert result.frequency[result.residual.argmax()] == pytest.approx(12, abs=0.3)
    assert result.residual.sum() * (result.frequency[1] - result.frequency[0]) == pytest.approx(0.02, rel=0.1)
    assert result.frequency[-1] <= prepared.bandwidth


def test_the_repeating_part_is_not_noise(planted: Planted, prepared: PreparedRecording, noise: Floats) -> None:
    repeating = np.nan_to_num(np.sin(2 * np.pi * 5 * prepared.phase))[:, None] * [1, 1, 1]
    result = spectrum([planted(repeating + noise)], 0)
    assert result.noise is not None
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
