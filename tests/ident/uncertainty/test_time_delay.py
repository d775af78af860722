"""Time delay between torque and motion, per joint."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from ident.data.prepared_recording import prepare
from ident.estimation.regression import Regression
from ident.uncertainty.time_delay import delays
from recordings.recording import Floats, Recording

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
    inside = []
    for seed in range(20):
        regression, parameters = fitted(make(cycles=1, noise=0.05, seed=seed))
        estimates = delays([regression], parameters)
        assert estimates is not None
        inside += [abs(delay.seconds) <= delay.half_width for delay in estimates]
    assert np.mean(inside) >= 0.85


def test_several_recordings_narrow_the_interval(make: Make) -> None:
    regression, parameters = fitted(make(cycles=1, noise=0.05))
    second, _ = fitted(make(cycles=1, noise=0.05, seed=1))
    single, both = delays([regression], parameters), delays([regression, second], parameters)
    assert single is not None
    assert both is not None
    assert both[0].half_width == pytest.approx(single[0].half_width / np.sqrt(2), rel=0.3)


def test_no_delay_is_estimated_if_the_model_contains_the_derivative_of_the_torque(make: Make) -> None:
    regression, parameters = fitted(make(cycles=1))
    from ident.uncertainty.time_delay import _slopes

    shapes = np.concatenate([regression.regressor, _slopes(regression, parameters)], axis=2)
    assert delays([replace(regression, regressor=shapes)], np.append(parameters, np.zeros(3))) is None
