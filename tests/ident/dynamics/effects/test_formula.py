"""One formula gives numbers, derivatives, C, text and LaTeX."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.dynamics.effects.base import Additive, Signal
from ident.dynamics.effects.formula import LATEX, TEXT, C, Formula, arguments, derivative, evaluate, traced
from ident.dynamics.effects.library import library
from ident.dynamics.effects.reading import PositionCorrection

LIBRARY = library()
FORMULAS: dict[str, Formula] = {
    name: effect.formula for name, effect in LIBRARY.items() if isinstance(effect, Additive) and effect.formula
}
READINGS: dict[str, Formula] = {
    name: effect.reading for name, effect in LIBRARY.items() if isinstance(effect, Signal) and effect.reading
}
PLAIN = {
    name: formula for name, formula in FORMULAS.items() if not {"J", "platform_velocity"} & {*arguments(formula)}
}
POSITIVE = st.floats(0.1, 2.0)


@pytest.mark.parametrize("name", PLAIN)
@given(data=st.data())
def test_an_expression_is_worth_what_its_formula_gives(name: str, data: st.DataObject) -> None:
    values = {argument: data.draw(POSITIVE, argument) for argument in arguments(PLAIN[name])}
    computed: Any = PLAIN[name](**values)
    expected = computed if isinstance(computed, tuple) else (computed,)
    for expression, number in zip(traced(PLAIN[name]), expected, strict=True):
        assert evaluate(expression, values) == pytest.approx(number)


def law(x: Any, y: Any) -> Any:
    return (np.sin(x * y) + x**3 / y - np.exp(-x) * np.cos(y)) * np.tanh(x - y) + (x / y) ** y


@given(POSITIVE, POSITIVE)
def test_a_derivative_is_the_slope(x: float, y: float) -> None:
    step, (expression,) = 1e-6, traced(law)
    by_x, by_y = (evaluate(derivative(expression, name), {"x": x, "y": y}) for name in "xy")
    assert by_x == pytest.approx((law(x + step, y) - law(x - step, y)) / (2 * step), rel=1e-4, abs=1e-6)
    assert by_y == pytest.approx((law(x, y + step) - law(x, y - step)) / (2 * step), rel=1e-4, abs=1e-6)


@pytest.mark.parametrize("name", READINGS)
@given(q=st.floats(-1.0, 1.0), size=st.floats(-0.01, 0.01))
def test_a_correction_inverts_the_reading(name: str, q: float, size: float) -> None:
    values = {key: np.array([3.0 if key == "N" else size]) for key in arguments(READINGS[name]) if key != "q"}
    true = np.array([[q]])
    correct = PositionCorrection(READINGS[name], values)
    np.testing.assert_allclose(correct(READINGS[name](q=true, **values)), true, atol=1e-12)
    step = 1e-5
    low, high = (READINGS[name](q=true + side * step, **values) for side in (-1, 1))
    np.testing.assert_allclose(correct.slopes(true)[0], 2 * step / (high - low), rtol=1e-6)


@pytest.mark.parametrize(
    ("formula", "code", "text", "latex"),
    [
        (lambda a, b: a - (b - 1.5), "a - (b - 1.5)", "a - (b - 1.5)", "a - (b - 1.5)"),
        (
            lambda a, qd: a / (2 * np.abs(qd)),
            "a / (2 * fabs(qd))",
            "a / (2 |v|)",
            r"\frac{a}{2 \, \left|\dot q\right|}",
        ),
        (
            lambda qd, v_s: np.exp(-((qd / v_s) ** 2)),
            "exp(-((qd / v_s) * (qd / v_s)))",
            "exp(-(v / v_s)^2)",
            r"\exp\left(-(\frac{\dot q}{v_{s}})^{2}\right)",
        ),
        (lambda q, N: np.sin(N * q) / 2, "sin(N * q) / 2", "sin(N q) / 2", r"\frac{\sin\left(N \, q\right)}{2}"),
        (
            lambda qd, alpha, direction: np.abs(qd) ** alpha * direction,
            "pow(fabs(qd), alpha) * direction",
            "|v|^alpha sgn v",
            r"\left|\dot q\right|^{\alpha} \, \operatorname{sgn} \dot q",
        ),
        (lambda J, m_p: m_p * -J[1], "m_p * -J[i][1]", "m_p (-J[1])", r"m_{p} \, (-J_y)"),
    ],
)
def test_printed(formula: Formula, code: str, text: str, latex: str) -> None:
    (expression,) = traced(formula)
    assert (C(expression), TEXT(expression), LATEX(expression)) == (code, text, latex)


def test_a_formula_cannot_branch() -> None:
    with pytest.raises(TypeError, match="the same everywhere"):
        traced(lambda q: np.where(q > 0, q, 0.0))
