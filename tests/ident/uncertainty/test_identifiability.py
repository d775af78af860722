"""Parameters that are not identifiable, or physically impossible, and the coupling of joints."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.dynamics import mechanisms
from ident.dynamics.mechanisms import Parameter
from ident.uncertainty.identifiability import UNIDENTIFIABLE, WEAK, identifiability, known_together
from ident.uncertainty.physical_consistency import coupling, violations
from recordings.recording import Floats
from tests.ident import building


def parameters(k: int) -> tuple[Parameter, ...]:
    return tuple(Parameter(f"p{i}", "kg", f"number {i}") for i in range(k))


def pair(index: float) -> Floats:
    """Products of two columns of unit length, whose condition number is `index`."""
    correlation = (index**2 - 1) / (index**2 + 1)
    return np.array([[1.0, correlation], [correlation, 1.0]])


@pytest.mark.parametrize(
    ("index", "status"),
    [(1.0, "identifiable"), (0.9 * WEAK, "identifiable"), (1.1 * WEAK, "weak"), (10 * UNIDENTIFIABLE, "not")],
)
def test_condition_number_of_two_columns_gives_the_status(index: float, status: str) -> None:
    result = identifiability(pair(index), parameters(2))
    assert status == "not" or result.condition == pytest.approx(index, rel=1e-4)
    assert sum(value**2 for value in result.singular_values) == pytest.approx(2.0)
    assert result.status == (status, status)


def test_collinear_columns_are_named_with_the_changes_that_cancel() -> None:
    """Column 2 is -3 times column 1; column 0 is independent: the changes 1 of p1 and 1/3 of p2 cancel."""
    columns = np.random.default_rng(0).normal(size=(500, 3))
    columns[:, 2] = -3 * columns[:, 1]
    result = identifiability(columns.T @ columns, parameters(3))
    assert result.status == ("identifiable", "not", "not")
    (combination,) = result.combinations
    assert combination.status == "not"
    assert set(combination.names) == {"p1", "p2"}
    changes = dict(zip(combination.names, (1.0, 3.0 if combination.names[0] == "p2" else 1 / 3), strict=True))
    assert all(f"{name} by {change:+.3g} kg" in combination.sentence for name, change in changes.items())
    assert "cannot be told apart by this motion" in combination.sentence
    assert "together do next to nothing" in combination.sentence
    assert "p0" not in combination.sentence


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


MASS = Parameter("m", "kg", "a mass", nonnegative=True)
FRICTION = Parameter("c", "N m", "friction", friction=True)
OFFSET = Parameter("a", "N m", "an offset")


def test_only_negative_masses_and_friction_are_impossible() -> None:
    values = np.array([-1.0, -2.0, -3.0])
    intervals = values[:, None] + [-0.5, 0.5]
    mass, friction = violations((MASS, FRICTION, OFFSET), values, intervals)
    assert (mass.name, mass.significant) == ("m", True)
    assert "must be positive for any body" in mass.sentence
    assert "friction would drive the motion" in friction.sentence
    assert violations((MASS, FRICTION, OFFSET), np.zeros(3), intervals) == ()
    for highest in (0.2, np.nan):
        (chance,) = violations((MASS,), np.array([-1.0]), np.array([[-2.2, highest]]))
        assert not chance.significant
        assert "this may be chance" in chance.sentence


@pytest.mark.parametrize(
    ("inertias", "positive"), [([0.1, 0.2, 0.3], True), ([0.1, -0.2, 0.3], False), ([0.1, 0.0, 0.3], False)]
)
def test_independent_axes_are_not_coupled(inertias: list[float], positive: bool) -> None:
    motion, values = building.motion_of(joints=3), np.array([*inertias, *np.ones(6)])
    regressor = mechanisms.create(building.bench(3)).regressor
    result = coupling(lambda moved: regressor(moved) @ values, motion)
    assert result is not None
    assert result.positive is positive
    assert np.isfinite(result.off_diagonal).all()
    if positive:
        np.testing.assert_allclose(result.off_diagonal, np.eye(3), atol=1e-12)
        assert result.share == pytest.approx(0.0, abs=1e-12)
    single = mechanisms.create(building.bench()).regressor
    assert coupling(lambda moved: single(moved) @ building.parameters(), building.motion_of()) is None


@pytest.mark.parametrize(
    ("names", "value", "said"),
    [
        (("spring.k1", "offset.a1"), -0.96, "one of the two effects may be all there is"),
        (("spring.k1", "offset.a1"), 0.94, None),
        (("T_g", "curve.g_1"), 0.999, "what one has too much, the other lacks"),
        (("c_v1", "drag.a1"), -0.97, None),
        (("T_g", "m_p"), 0.999, None),
        (("curve.g_1", "curve.g_2"), 0.999, None),
        (("T_g", "curve.g_1"), np.nan, None),
    ],
)
def test_what_imitates_each_other_is_known_only_together(
    names: tuple[str, str], value: float, said: str | None
) -> None:
    sentences = [*known_together(names, np.array([[1.0, value], [value, 1.0]]))]
    assert [sentence.partition(", so ")[2] for sentence in sentences] == ([f"{said}."] if said else [])
