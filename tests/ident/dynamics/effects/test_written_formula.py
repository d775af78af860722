"""Formulas as text: they are numbers, and nothing else is executed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.dynamics.effects.formula import TEXT, arguments
from ident.dynamics.effects.written_formula import WrittenFormula, parse
from recordings.errors import BadInput

FINITE = st.floats(-3.0, 3.0)


@given(q=FINITE, v=FINITE)
def test_text_is_the_number_that_it_says(q: float, v: float) -> None:
    formula = WrittenFormula("maximum(q - 0.5, 0) * qd", "-sin(2 * q) / (1 + qd ** 2)")
    assert arguments(formula) == ("q", "qd")
    expected = max(q - 0.5, 0) * v, -np.sin(2 * q) / (1 + v**2)
    np.testing.assert_allclose(formula(q, v), expected, atol=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').getcwd()",
        "q.real",
        "q if qd else t",
        "lambda: q",
        "[q]",
        "open(q)",
        "sin(q, out=qd)",
        "'text'",
        "q @ qd",
        "",
    ],
)
def test_what_is_no_formula_is_refused_and_not_executed(text: str) -> None:
    with pytest.raises(BadInput, match="formula: "):
        parse(text)


def test_text_is_printed_as_an_expression() -> None:
    assert TEXT(parse("a * tanh(qd / v)")) == "a tanh(v / v)"
