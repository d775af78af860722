"""Changes of the parameters under other assumptions, and the time delay between torque and motion of each joint."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from ident.basics.filters import first_derivative
from ident.data.prepared_recording import prepare
from ident.estimation.regression import Regression
from ident.uncertainty.sensitivity import CUTOFF_FACTORS, LENGTH_STEP, sensitivity, with_longer_rods
from ident.uncertainty.time_delay import delays
from recordings.recording import Floats, Recording
from tests.ident import building
from tests.ident.conftest import TRUTH, make_recording


def test_correct_model_does_not_depend_on_the_cutoff() -> None:
    result = sensitivity([building.record()], "parallel", 20.0)
    assert result.per_length_step is None  # axes have no rods
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


def test_change_per_length_predicts_the_fit_with_longer_rods() -> None:
    delta = make_recording(cycles=1, rate=250.0)
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


Make = Callable[..., Recording]


def fitted(recording: Recording) -> tuple[Regression, Floats]:
    regression = Regression.of_mechanism(prepare(recording, "parallel", None))
    return regression, np.linalg.lstsq(*regression.rows(), rcond=None)[0]


def test_a_planted_delay_is_found_joint_by_joint(make: Make) -> None:
    recording = make(cycles=2, noise=0.02)
    voltage = recording.voltage.copy()
    voltage[:-1, 1] = recording.voltage[1:, 1]  # the second joint is a sample early
    voltage[1:, 2] = recording.voltage[:-1, 2]  # the third joint is a sample late
    regression, parameters = fitted(replace(recording, voltage=voltage))
    estimates = delays([regression], parameters)
    assert estimates is not None
    for delay, expected in zip(estimates, (0.0, 0.002, -0.002), strict=True):
        assert delay.seconds == pytest.approx(expected, abs=2e-4)
        assert delay.half_width < 2e-4


def test_the_interval_covers_the_true_delay(make: Make) -> None:
    """Two recordings narrow it."""
    inside, widths = [], np.zeros(2)
    regression, parameters = fitted(make(cycles=1, noise=0.05))
    for seed in range(1, 21):
        other, parameters = fitted(make(cycles=1, noise=0.05, seed=seed))
        single, both = delays([other], parameters), delays([regression, other], parameters)
        assert single is not None
        assert both is not None
        inside += [abs(delay.seconds) <= delay.half_width for delay in single]
        widths += single[0].half_width, both[0].half_width
    assert np.mean(inside) >= 0.85
    assert widths[1] == pytest.approx(widths[0] / np.sqrt(2), rel=0.1)


def test_no_delay_is_estimated_if_the_model_contains_the_derivative_of_the_torque(make: Make) -> None:
    regression, parameters = fitted(make(cycles=1))
    slope = first_derivative(regression.predicted_torque(parameters), regression.prepared.rate)
    shapes = np.concatenate([regression.regressor, slope[:, :, None] * np.eye(3)], axis=2)
    assert delays([replace(regression, regressor=shapes)], np.append(parameters, np.zeros(3))) is None
