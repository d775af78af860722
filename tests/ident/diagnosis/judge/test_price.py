"""What parameters cost."""

import pytest

from ident.diagnosis.judge.price import PRICE, is_significant


@pytest.mark.parametrize("parameters", [1, 2, 7])
def test_every_parameter_has_to_earn_its_price(parameters: int) -> None:
    """Each explains 1 in 1,000 of the loss that is left by fitting noise alone, with 1,000 independent rows."""
    worth = PRICE * parameters / 1000
    assert is_significant(1.01 + worth, 1.0, parameters, 1000)
    assert not is_significant(0.99 + worth, 1.0, parameters, 1000)


def test_fewer_independent_rows_show_less() -> None:
    assert is_significant(1.2, 1.0, 5, 1000)
    assert not is_significant(1.2, 1.0, 5, 200)
