"""A model on a recording as a linear regression."""

import numpy as np
import pytest

from ident.estimation.predicted_torque import TorquePredictor
from ident.estimation.regression import Regression, linearize
from tests.ident import building


def test_mechanism_without_effects_is_its_own_regression() -> None:
    prepared = building.prepared(building.record(2))
    linear = linearize(prepared, building.structure(prepared.recording), np.zeros(6))
    np.testing.assert_array_equal(linear.regressor, prepared.regressor)
    assert linear.offset is None
    assert np.nanstd(linear.residual(building.parameters(2))) < 0.02


@pytest.mark.parametrize("name", ["stribeck", "actuation_delay", "encoder_eccentricity"])
def test_prediction_at_its_own_parameters_is_that_of_the_model(name: str) -> None:
    prepared = building.prepared(building.record(2))
    structure = building.structure(prepared.recording, name)
    x = np.array([0.5 if entry.linear else 0.3 * entry.scale for entry in structure.parameters])
    linear = linearize(prepared, structure, x)
    predicted, expected = linear.predicted_torque(x[structure.linear]), TorquePredictor(prepared).torque(structure, x)
    known = np.isfinite(predicted)
    assert known.mean() > 0.9
    np.testing.assert_allclose(predicted[known], expected[known], atol=1e-9)
    assert (linear.offset is None) == (name == "stribeck")


def test_rows_are_usable_ones_joint_after_joint_without_the_offset() -> None:
    recording = building.record(2)
    assert recording.effort is not None
    recording.effort[500:600, 1] = np.nan
    prepared = building.prepared(recording)
    shifted = Regression(prepared, prepared.regressor, prepared.torque, np.full_like(prepared.torque, 0.25))
    regressor, torque = shifted.rows()
    counts = prepared.usable.sum(axis=0)
    assert counts[1] < counts[0]
    assert len(torque) == len(regressor) == counts.sum()
    np.testing.assert_allclose(torque[: counts[0]], prepared.torque[prepared.usable[:, 0], 0] - 0.25)
    np.testing.assert_allclose(torque[counts[0] :], prepared.torque[prepared.usable[:, 1], 1] - 0.25)
