"""Formulas as text: parsed to expressions, never executed, and printed so that they can be parsed."""

import ast
import inspect
from collections.abc import Callable
from typing import Any

import numpy as np

from ident.dynamics.effects.formula import ARITHMETIC, Notation, Symbol, evaluate, symbol
from recordings.errors import BadInput

FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sin": np.sin,
    "cos": np.cos,
    "arctan": np.arctan,
    "tanh": np.tanh,
    "exp": np.exp,
    "log": np.log,
    "abs": np.abs,
    "sqrt": np.sqrt,
    "hypot": np.hypot,
    "sign": np.sign,
    "minimum": np.minimum,
    "maximum": np.maximum,
}
_OPERATORS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: lambda x, y: x + y,
    ast.Sub: lambda x, y: x - y,
    ast.Mult: lambda x, y: x * y,
    ast.Div: lambda x, y: x / y,
    ast.Pow: lambda x, y: x**y,
}
_NUMPY_NAMES = {function.__name__: name for name, function in FUNCTIONS.items()}
_TEXT = Notation(
    ARITHMETIC | {"power": ("{} ** {}", (5, 4), 4)},
    lambda function, alone: (f"{_NUMPY_NAMES[function]}({{}})", 5),
    lambda name: (name, 5),
    repr,
)


def as_text(expression: Any) -> str | None:
    """The text that `parse` reads as the `expression`; None if it has more than arithmetic and FUNCTIONS."""
    try:
        text = _TEXT(expression)
        parse(text)
    except (KeyError, BadInput):
        return None
    return text


class WrittenFormula:
    """A formula that is called as a function of the quantities that it names, see `formula`."""

    def __init__(self, *texts: str) -> None:
        self.texts = texts
        self.expressions = tuple(map(parse, texts))
        names = dict.fromkeys(name for each in self.expressions for name in _names(each))
        self.__signature__ = inspect.Signature(
            [inspect.Parameter(name, inspect.Parameter.POSITIONAL_OR_KEYWORD) for name in names]
        )

    def __reduce__(self) -> Any:
        """Pickle the texts."""
        return WrittenFormula, self.texts

    def __call__(self, *values: Any) -> Any:
        """Compute the columns from the `values` of the quantities in their order."""
        by_name = dict(zip(self.__signature__.parameters, values, strict=True))
        return tuple(evaluate(each, by_name) for each in self.expressions)


def parse(text: str) -> Any:
    """The expression that `text` is.

    Raises:
        BadInput: it is no expression of named quantities, numbers, arithmetic and FUNCTIONS.
    """
    try:
        return _expression(ast.parse(text, mode="eval").body)
    except (SyntaxError, ValueError) as error:
        raise BadInput(
            f"formula: named quantities, numbers, + - * / ** and {', '.join(FUNCTIONS)} expected, {text!r} found"
        ) from error


def _expression(node: ast.expr) -> Any:
    match node:
        case ast.Constant(value=int() | float() as value):
            return value
        case ast.Name(id=name):
            return symbol(name)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_expression(operand)
        case ast.BinOp(left=left, op=operator, right=right) if type(operator) in _OPERATORS:
            return _OPERATORS[type(operator)](_expression(left), _expression(right))
        case ast.Call(func=ast.Name(id=name), args=operands, keywords=[]) if name in FUNCTIONS:
            return FUNCTIONS[name](*map(_expression, operands))
    raise ValueError


def _names(expression: Any) -> list[str]:
    if not isinstance(expression, Symbol):
        return []
    if expression.function == "name":
        return [expression.operands[0]]
    return [name for operand in expression.operands for name in _names(operand)]
