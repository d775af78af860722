"""The residual above the low-pass."""

import numpy as np
import pytest

from ident.diagnosis.ripple.high_band import HIGHEST_SHARE, high_bands
from recordings.recording import Floats
from tests.ident import building

FAST, SLOW = 80.0, 3.0


def _sine(hertz: float) -> Floats:
    return np.sin(2 * np.pi * hertz * np.arange(4000) / building.RATE)[:, None]


@pytest.mark.parametrize(("hertz", "share"), [(FAST, 1.0), (SLOW, 0.0)])
def test_only_what_the_low_pass_removes_is_left(hertz: float, share: float) -> None:
    model = building.fitted(building.split([building.record(extra=lambda motion: _sine(hertz))]))
    (band,) = high_bands(model.split, model.solution)
    assert np.nanstd(band.residual) == pytest.approx(share / np.sqrt(2), abs=0.05)
    assert (band.low, band.highest) == (building.CUTOFF, HIGHEST_SHARE * building.RATE)


def test_samples_of_training_rows_and_test_rows_do_not_overlap() -> None:
    model = building.fitted(building.split([building.record(noise=0.1)]))
    (band,) = high_bands(model.split, model.solution)
    assert band.train.any()
    assert band.test.any()
    assert not (band.train & band.test).any()


def test_band_has_an_upper_end_where_wanted() -> None:
    model = building.fitted(building.split([building.record()]))
    (band,) = high_bands(model.split, model.solution)
    assert np.nanstd(band.below(_sine(FAST), 40.0)) < 0.05
    assert band.below(_sine(FAST), band.highest) is not None
