"""The delay between torque and motion, per joint."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from ident.data.dataset import Dataset, build
from ident.dynamics import mechanisms
from ident.uncertainty.time_delay import delays
from recordings.recording import Floats, Recording

Make = Callable[..., Recording]


def fitted(recording: Recording) -> tuple[Dataset, Floats]:
    dataset = build(recording, mechanisms.create(recording.rig), "parallel", None)
    return dataset, np.linalg.lstsq(*dataset.rows(), rcond=None)[0]


def test_a_planted_delay_is_found_joint_by_joint(make: Make) -> None:
    made = make(cycles=2, noise=0.02)
    voltage = made.voltage.copy()
    voltage[:-1, 1] = made.voltage[1:, 1]  # the second joint's is a sample early
    voltage[1:, 2] = made.voltage[:-1, 2]  # the third one's late
    dataset, parameters = fitted(replace(made, voltage=voltage))
    found = delays([dataset], parameters)
    assert found is not None
    for one, expected in zip(found, (0.0, 0.002, -0.002), strict=True):
        assert one.seconds == pytest.approx(expected, abs=2e-4)
        assert one.half_width < 2e-4


def test_the_interval_holds_the_truth(make: Make) -> None:
    inside = []
    for seed in range(20):
        dataset, parameters = fitted(make(cycles=1, noise=0.05, seed=seed))
        found = delays([dataset], parameters)
        assert found is not None
        inside += [abs(one.seconds) <= one.half_width for one in found]
    assert np.mean(inside) >= 0.85


def test_several_recordings_narrow_the_interval(make: Make) -> None:
    dataset, parameters = fitted(make(cycles=1, noise=0.05))
    other, _ = fitted(make(cycles=1, noise=0.05, seed=1))
    one, both = delays([dataset], parameters), delays([dataset, other], parameters)
    assert one is not None
    assert both is not None
    assert both[0].half_width == pytest.approx(one[0].half_width / np.sqrt(2), rel=0.3)


def test_a_model_that_holds_every_shape_tells_of_no_delay(make: Make) -> None:
    dataset, parameters = fitted(make(cycles=1))
    from ident.uncertainty.time_delay import _slopes

    shapes = np.concatenate([dataset.regressor, _slopes(dataset, parameters)], axis=2)
    assert delays([replace(dataset, regressor=shapes)], np.append(parameters, np.zeros(3))) is None
