"""Curves that are learned from what remains."""

import numpy as np
import pytest

from ident.diagnosis.nonparametric_fit import KNOTS, SMOOTHNESS, _Rows


@pytest.mark.parametrize("rows_of_first", [0, 40])
def test_a_curve_that_one_half_of_the_rows_does_not_visit_has_a_solution(rows_of_first: int) -> None:
    rng = np.random.default_rng(0)
    first = np.arange(100) < rows_of_first
    hats = rng.uniform(0, 1, (100, KNOTS)) * ~first[:, None]
    bend = np.diff(np.eye(KNOTS), n=2, axis=0)
    rows = _Rows(hats, rng.normal(size=(100, 2)), hats.sum(axis=1), first, bend)
    for smoothness in SMOOTHNESS:
        assert np.isfinite(rows.error(smoothness))
