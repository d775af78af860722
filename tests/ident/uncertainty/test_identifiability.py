"""Identifiability of parameters, for matrices whose singular values are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.dynamics.mechanisms import Parameter
from ident.uncertainty.identifiability import UNIDENTIFIABLE, WEAK, identifiability
from recordings.recording import Floats


def parameters(k: int) -> tuple[Parameter, ...]:
    return tuple(Parameter(f"p{i}", "kg", f"number {i}") for i in range(k))


def pair(correlation: float) -> Floats:
    """Products of two columns of unit length; singular values sqrt(1 + r), sqrt(1 - r)."""
    return np.array([[1.0, correlation], [correlation, 1.0]])


def correlation_of(index: float) -> float:
    """Correlation of two columns whose condition number is `index`."""
    return (index**2 - 1) / (index**2 + 1)


@given(index=st.floats(1.0, 1e3))
def test_condition_number_of_two_columns(index: float) -> None:
    result = identifiability(pair(correlation_of(index)), parameters(2))
    assert result.condition == pytest.approx(index, rel=1e-4)
    assert result.singular_values[0] ** 2 + result.singular_values[1] ** 2 == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("index", "status"), [(0.9 * WEAK, "identifiable"), (1.1 * WEAK, "weak"), (10 * UNIDENTIFIABLE, "not")]
)
def test_status_follows_the_condition_number(index: float, status: str) -> None:
    result = identifiability(pair(correlation_of(index)), parameters(2))
    assert result.status == (status, status)


def test_orthogonal_columns_of_any_size_are_perfectly_conditioned() -> None:
    result = identifiability(np.diag([1e-8, 1.0, 1e8]), parameters(3))
    assert result.condition == pytest.approx(1.0)
    assert result.status == ("identifiable",) * 3
    assert result.combinations == ()


def test_collinear_columns_are_named_and_others_are_not() -> None:
    """Column 3 is twice column 1 less column 2; column 0 is independent."""
    rng = np.random.default_rng(0)
    columns = rng.normal(size=(500, 4))
    columns[:, 3] = 2 * columns[:, 1] - columns[:, 2]
    result = identifiability(columns.T @ columns, parameters(4))
    assert result.status == ("identifiable", "not", "not", "not")
    (combination,) = result.combinations
    assert combination.status == "not"
    assert set(combination.names) == {"p1", "p2", "p3"}
    assert "cannot be told apart by this motion" in combination.sentence
    assert "p0" not in combination.sentence


def test_sentence_gives_the_changes_that_cancel() -> None:
    """With x_1 = -3 x_0, the changes 1 of p0 and 1/3 of p1 cancel."""
    x = np.random.default_rng(0).normal(size=100)
    columns = np.stack([x, -3 * x], axis=1)
    (combination,) = identifiability(columns.T @ columns, parameters(2)).combinations
    changes = dict(zip(combination.names, (1.0, 3.0 if combination.names[0] == "p1" else 1 / 3), strict=True))
    assert all(f"{name} by {change:+.3g} kg" in combination.sentence for name, change in changes.items())
    assert "together do next to nothing" in combination.sentence


@given(seed=st.integers(0, 2**32 - 1), scales=st.lists(st.floats(1e-5, 1e5), min_size=4, max_size=4))
def test_units_and_order_of_parameters_do_not_matter(seed: int, scales: list[float]) -> None:
    rng = np.random.default_rng(seed)
    columns = rng.normal(size=(30, 4))
    columns[:, 2] += 50 * columns[:, 0]
    expected = identifiability(columns.T @ columns, parameters(4))
    scaled = columns * scales
    result = identifiability(scaled.T @ scaled, parameters(4))
    assert result.condition == pytest.approx(expected.condition, rel=1e-3)
    assert result.status == expected.status
    order = rng.permutation(4)
    names = tuple(parameters(4)[i] for i in order)
    permuted = identifiability((columns.T @ columns)[np.ix_(order, order)], names)
    assert permuted.condition == pytest.approx(expected.condition, rel=1e-3)
    assert permuted.status == tuple(expected.status[i] for i in order)
