"""Choice of the joints of an effect."""

import numpy as np
import pytest

from ident.diagnosis.search.joint_subsets import Products, choose_joints
from recordings.recording import Floats

ANY_SIGN = np.zeros(1)


def products(columns: Floats, residual: Floats, one_signed: Floats = ANY_SIGN) -> Products:
    return Products(columns.T @ columns, columns.T @ residual, 0.0, one_signed, np.arange(0))


def columns(count: int) -> Floats:
    """(60, count) columns that are nearly orthogonal."""
    return np.random.default_rng(3).normal(size=(60, count))


def test_joints_that_add_little_are_left_out() -> None:
    matrix = columns(3)
    chosen = choose_joints(products(matrix, matrix @ [2.0, 0.01, -1.0]), range(3))
    assert chosen is not None
    assert chosen[0] == (0, 2)
    np.testing.assert_allclose(chosen[2], [2.0, -1.0], atol=0.01)


def test_reduction_is_the_fall_of_the_sum_of_squares() -> None:
    matrix, residual = columns(4), np.random.default_rng(4).normal(size=60)
    reduction, coefficients = products(matrix, residual, np.zeros(2)).reduction((0, 1))
    error = residual - matrix @ coefficients
    assert reduction == pytest.approx(residual @ residual - error @ error)
    assert coefficients == pytest.approx(np.linalg.lstsq(matrix, residual)[0])


def test_joint_with_an_impossible_sign_is_not_chosen() -> None:
    matrix = columns(2)
    residual, positive = matrix @ [1.0, -1.0], np.ones(1)
    chosen = choose_joints(products(matrix, residual, positive), range(2))
    assert chosen is not None
    assert chosen[0] == (0,)
    assert choose_joints(products(matrix, -residual, positive), [0]) is None


def test_replaced_column_costs_what_it_explained() -> None:
    """A column of the model equal to that of the effect: nothing is gained by the exchange."""
    friction = columns(1)
    target, both = 3.0 * friction[:, 0], np.concatenate([friction, friction], axis=1)
    exchange = Products(both.T @ both, both.T @ target, float(target @ target), ANY_SIGN, np.array([1]))
    reduction, coefficients = exchange.reduction((0,))
    assert coefficients == pytest.approx([3.0])
    assert reduction == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("joints", "chosen_joints"), [(4, (0, 3)), (6, (0, 1, 2, 3, 4, 5))])
def test_with_many_joints_only_each_alone_and_all_are_tried(joints: int, chosen_joints: tuple[int, ...]) -> None:
    matrix = columns(joints)
    chosen = choose_joints(products(matrix, matrix[:, 0] + matrix[:, 3]), range(joints))
    assert chosen is not None
    assert chosen[0] == chosen_joints
