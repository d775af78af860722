"""Curves fitted to the unexplained residual."""

import numpy as np
import pytest

from ident.diagnosis.nonparametric_fit import KNOTS, SMOOTHNESS, _Rows


@pytest.mark.parametrize("first_half_rows", [0, 40])
def test_curve_without_rows_in_one_half_has_a_solution(first_half_rows: int) -> None:
    rng = np.random.default_rng(0)
    first_half = np.arange(100) < first_half_rows
    hats = rng.uniform(0, 1, (100, KNOTS)) * ~first_half[:, None]
    slope_changes = np.diff(np.eye(KNOTS), n=2, axis=0)
    rows = _Rows(hats, rng.normal(size=(100, 2)), hats.sum(axis=1), first_half, slope_changes)
    for smoothness in SMOOTHNESS:
        assert np.isfinite(rows.cross_validation_error(smoothness))
