"""Normal equations of a regression."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ident.diagnosis.unknown.normal_equations import NormalEquations


@given(seed=st.integers(0, 1000), columns=st.integers(1, 6), rows=st.integers(8, 40))
def test_solution_and_remaining_error_are_those_of_the_rows(seed: int, columns: int, rows: int) -> None:
    rng = np.random.default_rng(seed)
    x, y = rng.normal(size=(rows, columns)), rng.normal(size=rows)
    equations = NormalEquations.of(x[: rows // 2], y[: rows // 2]) + NormalEquations.of(
        x[rows // 2 :], y[rows // 2 :]
    )
    coefficients = equations.solve(np.zeros((columns, columns)))
    np.testing.assert_allclose(coefficients, np.linalg.lstsq(x, y, rcond=None)[0], rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(equations.remaining(coefficients), np.sum((y - x @ coefficients) ** 2), rtol=1e-9)


def test_selected_columns_are_those_of_the_rows() -> None:
    rng = np.random.default_rng(0)
    x, y, entries = rng.normal(size=(20, 5)), rng.normal(size=20), np.array([3, 1])
    selected, expected = NormalEquations.of(x, y).of_columns(entries), NormalEquations.of(x[:, entries], y)
    np.testing.assert_allclose(selected.gram, expected.gram)
    np.testing.assert_allclose(selected.moment, expected.moment)


def test_penalty_shrinks_what_no_row_determines() -> None:
    equations = NormalEquations.of(np.array([[1.0, 0.0], [1.0, 0.0]]), np.array([2.0, 2.0]))
    np.testing.assert_allclose(equations.solve(np.diag([0.0, 1.0])), [2.0, 0.0])
    np.testing.assert_allclose(equations.solve(np.diag([1.0, 1.0])), [1.0, 0.0])
