"""Curves fitted to the unexplained residual."""

from dataclasses import replace

import numpy as np
import pytest

from ident.diagnosis.split.split_data import SplitData
from ident.diagnosis.unknown.nonparametric_fit import (
    KNOTS,
    SMOOTHNESS,
    NonparametricFit,
    _Rows,
    fit_curves,
    fit_curves_over,
)
from ident.diagnosis.unknown.residual_dependence import CurveInput, ResidualDependence
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


@pytest.mark.parametrize(("size", "joints"), [(0.1, {1}), (0.6, {1, 2})])
def test_residual_that_is_small_beside_the_largest_is_not_described(size: float, joints: set[int]) -> None:
    """It may be what the curves of the other joint left."""
    _, result = dependent(lambda motion: np.sin(1.5 * motion.velocity) * [1.0, size])
    assert result is not None
    assert {curve.joint for curve in result.curves} == {1, 2}
    assert {dependence.joint + 1 for dependence in result.described} == joints


def test_rows_beyond_the_knots_are_not_within_them() -> None:
    """The second recording moves farther than the first one, whose positions the knots span."""
    small, large = (building.record(noise=0.02, extra=bump, size=size) for size in (1.0, 2.0))
    result = fit_curves_over(building.fitted(building.split([small], [large])), [over_position(0)])
    (curve,) = result.curves
    for data, inside in zip(result.model.split.recordings, result.within_knots(), strict=True):
        position = data.motion.position[:, 0]
        assert (inside == ((position >= curve.knots[0]) & (position <= curve.knots[-1]))).all()
    shares = [inside.mean() for inside in result.within_knots()]
    assert shares[0] > 0.9
    assert 0.1 < shares[1] < 0.9


def test_explained_share_is_that_of_the_residual_beside_the_model() -> None:
    data = building.split([building.record(noise=0.02, extra=bump)])
    final = building.fitted(data)
    before = replace(over_position(0), explained=0.5)
    (after,) = fit_curves_over(final, [before]).with_explained_of(final).dependences
    assert after.explained > 0.95
    assert (after.inputs, after.variables) == (before.inputs, before.variables)


def bump(motion: Motion) -> Floats:
    return np.exp(-((4 * motion.position) ** 2))


def over_position(joint: int) -> ResidualDependence:
    return ResidualDependence(joint, (CurveInput("position", joint),), ("position",), 1.0)
