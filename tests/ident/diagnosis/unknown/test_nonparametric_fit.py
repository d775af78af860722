"""Curves fitted to the unexplained residual."""

import numpy as np
import pytest

from ident.diagnosis.split.split_data import SplitData
from ident.diagnosis.unknown.nonparametric_fit import NonparametricFit, fit_curves
from ident.diagnosis.unknown.unexplained_residual import estimate_unexplained
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from tests.ident import building


def dependent(extra: building.Torque | None, noise: float = 0.02) -> tuple[SplitData, NonparametricFit | None]:
    data = building.split([building.record(2, noise=noise, extra=extra)])
    model = building.fitted(data)
    dependences = estimate_unexplained(model).dependences
    return data, fit_curves(model, dependences) if dependences else None


def test_curve_is_the_planted_one_up_to_the_model() -> None:
    """Coulomb and viscous friction of the model may take a part of it: the sum is that of the plant."""
    data, result = dependent(lambda motion: np.sin(1.5 * motion.velocity) * [1.0, 0.0])
    assert result is not None
    assert result.supported
    assert [(curve.joint, curve.variable, curve.variable_joint) for curve in result.curves] == [(1, "velocity", 1)]
    assert result.improvement.share > 0.95
    (residual,) = result.model.residuals
    assert np.nanstd(residual[data.scored[0][:, 0], 0]) < 0.1


def test_correct_model_needs_no_curve() -> None:
    assert dependent(None, noise=0.2)[1] is None


def test_drift_is_learned_over_time() -> None:
    def drift(motion: Motion) -> Floats:
        return np.linspace(-1, 1, len(motion.position))[:, None] * [0.0, 1.0]

    _, result = dependent(drift)
    assert result is not None
    assert [(curve.joint, curve.variable) for curve in result.curves] == [(2, "time")]
    assert result.supported


@pytest.mark.parametrize(("size", "joints"), [(0.1, {1}), (0.6, {1, 2})])
def test_residual_that_is_small_beside_the_largest_gets_no_curve(size: float, joints: set[int]) -> None:
    _, result = dependent(lambda motion: np.sin(1.5 * motion.velocity) * [1.0, size])
    assert result is not None
    assert {curve.joint for curve in result.curves} == joints
