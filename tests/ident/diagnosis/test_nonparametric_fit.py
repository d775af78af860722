"""Curves fitted to the unexplained residual."""

import numpy as np
import pytest

from ident.diagnosis.nonparametric_fit import KNOTS, SMOOTHNESS, NonparametricFit, _Rows, fit_curves
from ident.diagnosis.split_data import SplitData
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from tests.ident import building


@pytest.mark.parametrize("first_half_rows", [0, 40])
def test_curve_without_rows_in_one_half_has_a_solution(first_half_rows: int) -> None:
    rng = np.random.default_rng(0)
    first_half = np.arange(100) < first_half_rows
    hats = rng.uniform(0, 1, (100, KNOTS)) * ~first_half[:, None]
    slope_changes = np.diff(np.eye(KNOTS), n=2, axis=0)
    rows = _Rows(hats, rng.normal(size=(100, 2)), hats.sum(axis=1), first_half, slope_changes)
    for smoothness in SMOOTHNESS:
        assert np.isfinite(rows.cross_validation_error(smoothness))


def dependent(extra: building.Torque | None, noise: float = 0.02) -> tuple[SplitData, NonparametricFit | None]:
    data = building.split([building.record(2, noise=noise, extra=extra)])
    return data, fit_curves(building.fitted(data))


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
