"""Changes of the parameters under other assumptions."""

from dataclasses import replace

import numpy as np
import pytest

from ident.data.prepared_recording import prepare
from ident.estimation.regression import Regression
from ident.uncertainty.sensitivity import CUTOFF_FACTORS, LENGTH_STEP, sensitivity, with_longer_rods
from recordings.recording import Recording
from tests.ident import building
from tests.ident.conftest import TRUTH, make_recording


@pytest.fixture(scope="module")
def delta() -> Recording:
    return make_recording(cycles=1, rate=250.0)


def test_axes_have_no_rods() -> None:
    result = sensitivity([building.record()], "parallel", 20.0)
    assert result.per_length_step is None


def test_correct_model_does_not_depend_on_the_cutoff() -> None:
    result = sensitivity([building.record()], "parallel", 20.0)
    assert [hz for hz, _ in result.per_cutoff] == [factor * 20.0 for factor in CUTOFF_FACTORS]
    for _, change in result.per_cutoff:
        np.testing.assert_allclose(change, 0.0, atol=5e-3)


def test_wrong_model_depends_on_the_cutoff() -> None:
    """A torque of 11 Hz that follows the sign of the motion is inside of one cut-off and outside of the other."""
    ripple = building.record(extra=lambda motion: 2.0 * np.sign(np.sin(40 * motion.position)) * motion.direction)
    result = sensitivity([ripple], "parallel", 8.0)
    assert max(np.abs(change).max() for _, change in result.per_cutoff) > 2e-2


def test_other_cutoff_is_limited_by_the_rate_and_absent_without_a_cutoff() -> None:
    recording = building.record(rate=100.0)
    result = sensitivity([recording], "parallel", 15.0)
    assert [hz for hz, _ in result.per_cutoff] == [7.5, 20.0]
    assert sensitivity([recording], "savgol", None).per_cutoff == ()


def test_length_changes_only_the_rods(delta: Recording) -> None:
    longer = with_longer_rods(delta, 0.02)
    assert longer.rig.geometry.L2 == pytest.approx(delta.rig.geometry.L2 + 0.02)
    assert replace(longer, rig=delta.rig).rig == delta.rig
    assert longer.rig.geometry.L1 == delta.rig.geometry.L1


def test_change_per_length_predicts_the_fit_with_longer_rods(delta: Recording) -> None:
    change = sensitivity([delta], "parallel", 20.0).per_length_step
    assert change is not None
    half = with_longer_rods(delta, LENGTH_STEP / 2)
    rows = Regression.of_mechanism(prepare(half, "parallel", 20.0)).rows()
    refitted = np.linalg.lstsq(*rows, rcond=None)[0]
    np.testing.assert_allclose(refitted - TRUTH, change / 2, atol=0.1 * np.abs(change).max())
    assert np.abs(change).max() > 1e-3


def test_only_the_first_minute_of_the_repeated_motion_counts() -> None:
    """A fault after 60 s changes nothing."""
    long = building.record(cycles=36, rate=50.0)
    assert long.effort is not None
    faulty = replace(long, effort=long.effort + np.where(long.time > 61.0, 100.0, 0.0)[:, None])
    expected, result = (sensitivity([x], "parallel", 5.0) for x in (long, faulty))
    for (_, change), (_, same) in zip(expected.per_cutoff, result.per_cutoff, strict=True):
        np.testing.assert_array_equal(change, same)
