"""Formulas of effects: functions of named quantities, written once with NumPy's functions.

With arrays a formula gives numbers, with symbols an expression, which can be differentiated and printed as C, as text
and as LaTeX. A formula names what it needs as its arguments: its effect's parameters and shapes, and of the motion

    q, qd, qdd, direction     position, velocity and acceleration of the joint, the sign of its velocity
    t, dt                     time since the start, and between samples [s]
    temperature               of the joint's drive [degC]
    rigid                     the joint's torque without friction and effects
    load                      the same with that of the effects on the arms
    c_v, c_c                  the joint's viscous and Coulomb friction
    m_p, T_g, m_d, L1         parameters and length of a delta robot; cos_phi, sin_phi: direction of its limb
    J                         (J[0], J[1], J[2]): velocity of the platform per velocity of the joint, Eq. (16)
    platform_velocity         (3 entries) of the platform along x, y, z
    torque_per_mass, rods     the joint's torque for 1 kg at the platform, and for rods of 1 kg
    q1, qd2, qdd3, ...        q, qd, qdd, direction and rigid of the joint with this number, whichever has the effect
"""

import functools
import inspect
import operator
import re
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

Formula = Callable[..., Any]
Printed = tuple[str, int]
"""A text, and how strongly its parts hold together: 1 sums, 2 quotients and signs, 3 products, 4 powers and
functions, 5 names."""

VECTORS = ("J", "platform_velocity")
"""Quantities with three entries."""


class Symbol(NDArrayOperatorsMixin):
    """A name, or what one of NumPy's functions makes of symbols and numbers."""

    def __init__(self, function: str, *operands: Any) -> None:
        self.function, self.operands = function, operands

    def __bool__(self) -> bool:
        raise TypeError("a formula is the same everywhere; use NumPy's sign, abs, minimum in place of a condition")

    def __array_ufunc__(self, function: np.ufunc, method: str, *operands: Any, **options: Any) -> "Symbol":
        return NotImplemented if method != "__call__" or options else Symbol(function.__name__, *operands)


OF_JOINT = re.compile(r"(q|qd|qdd|direction|rigid)([1-9]\d*)")
"""Quantities of a joint whose number, from 1, follows."""


def symbol(name: str) -> Any:
    """Return the symbol of a named quantity: three of them for a vector."""
    return tuple(Symbol("name", f"{name}[{k}]") for k in range(3)) if name in VECTORS else Symbol("name", name)


@lru_cache(maxsize=1024)
def arguments(formula: Formula) -> tuple[str, ...]:
    """Names of the quantities on which `formula` depends."""
    return tuple(inspect.signature(formula).parameters)


def unknown_arguments(name: str, formula: Formula, known: Collection[str]) -> Iterator[str]:
    """Yield what is wrong with the arguments of the `formula` that a description has under `name`."""
    for argument in arguments(formula):
        if argument not in known and not OF_JOINT.fullmatch(argument):
            yield f"{name}: arguments out of {', '.join(known)} expected, {argument!r} found"


@lru_cache(maxsize=1024)
def traced(formula: Formula) -> tuple[Any, ...]:
    """The expressions of `formula`: what it returns for symbols."""
    result = formula(*map(symbol, arguments(formula)))
    return result if isinstance(result, tuple) else (result,)


def sum_of_products(factors: Sequence[str], expressions: Sequence[Any]) -> Any:
    """The sum of the `expressions`, each multiplied by the quantity that a factor names."""
    parts = [_product(symbol(name), expression) for name, expression in zip(factors, expressions, strict=True)]
    return functools.reduce(operator.add, parts)


def evaluate(expression: Any, values: Mapping[str, Any]) -> Any:
    """Compute an `expression` with `values` by name, which broadcast."""
    if not isinstance(expression, Symbol):
        return expression
    if expression.function == "name":
        return values[expression.operands[0]]
    return getattr(np, expression.function)(*(evaluate(operand, values) for operand in expression.operands))


def derivative(expression: Any, name: str) -> Any:
    """Differentiate an `expression` by the quantity `name`; 0 where it does not depend on it."""
    if not isinstance(expression, Symbol):
        return 0
    if expression.function == "name":
        return int(expression.operands[0] == name)
    slopes = [derivative(operand, name) for operand in expression.operands]
    partials = _PARTIAL[expression.function](*expression.operands)
    parts = [_product(x, y) for x, y in zip(partials, slopes, strict=True) if not _is(y, 0)]
    return functools.reduce(operator.add, parts) if parts else 0


_PARTIAL: dict[str, Callable[..., tuple[Any, ...]]] = {
    "add": lambda x, y: (1, 1),
    "subtract": lambda x, y: (1, -1),
    "multiply": lambda x, y: (y, x),
    "divide": lambda x, y: (1 / y, -x / y**2),
    "power": lambda x, n: (n * x ** (n - 1), x**n * np.log(x)),
    "negative": lambda x: (-1,),
    "sin": lambda x: (np.cos(x),),
    "cos": lambda x: (-np.sin(x),),
    "exp": lambda x: (np.exp(x),),
    "tanh": lambda x: (1 - np.tanh(x) ** 2,),
}
"""Partial derivatives of functions by their operands."""


def _product(x: Any, y: Any) -> Any:
    return x if _is(y, 1) else y if _is(x, 1) else -x if _is(y, -1) else -y if _is(x, -1) else x * y


def _is(x: Any, number: int) -> bool:
    return not isinstance(x, Symbol) and x == number


class Notation:
    """What prints expressions; see `C`, `TEXT` and `LATEX`."""

    def __init__(
        self,
        function: Callable[..., Printed],
        name: Callable[[str], Printed],
        number: Callable[[float], str],
    ) -> None:
        self._function, self._name, self._number = function, name, number

    def __call__(self, expression: Any) -> str:
        """Print the `expression`."""
        return self._print(expression)[0]

    def _print(self, expression: Any) -> Printed:
        if not isinstance(expression, Symbol):
            return self._number(expression), 5 if expression >= 0 else 3
        if expression.function == "name":
            return self._name(expression.operands[0])
        return self._function(expression.function, expression.operands, self._within)

    def _within(self, expression: Any, strength: int) -> str:
        """Print a part of an expression, in brackets where it holds together less than `strength`."""
        text, holds = self._print(expression)
        return text if holds >= strength else f"({text})"


_SIGNS = {"add": "+", "subtract": "-"}
_C_NAMES = {"absolute": "fabs", "minimum": "fmin", "maximum": "fmax", "power": "pow"}


def _in_c(function: str, operands: tuple[Any, ...], within: Callable[[Any, int], str]) -> Printed:
    if function in _SIGNS:
        return f"{within(operands[0], 1)} {_SIGNS[function]} {within(operands[1], 2)}", 1
    if function in ("multiply", "divide"):
        return f"{within(operands[0], 2)} {'*' if function == 'multiply' else '/'} {within(operands[1], 3)}", 2
    if function == "negative":
        return f"-{within(operands[0], 3)}", 3
    if function == "power" and _is(operands[1], 2):
        return " * ".join([within(operands[0], 4)] * 2), 2
    return f"{_C_NAMES.get(function, function)}({', '.join(within(operand, 0) for operand in operands)})", 5


_C_QUANTITIES = {"J": "J[i]", "platform_velocity": "velocity"}


def _c_name(name: str) -> Printed:
    head, bracket, index = name.partition("[")
    return _C_QUANTITIES.get(head, head) + bracket + index, 5


C = Notation(_in_c, _c_name, lambda x: str(x) if isinstance(x, int) else f"R({float(x)!r})")


def c_statements(results: Mapping[str, Any]) -> list[str]:
    """C that computes the `results`, expressions by where they go; what several of them share is computed once."""
    used: Counter[int] = Counter()
    lines: list[str] = []
    shared: dict[int, Symbol] = {}

    def count(expression: Any) -> None:
        used[id(expression)] += 1
        if isinstance(expression, Symbol) and expression.function != "name" and used[id(expression)] == 1:
            for operand in expression.operands:
                count(operand)

    def shortened(expression: Any) -> Any:
        if not isinstance(expression, Symbol) or expression.function == "name":
            return expression
        if id(expression) not in shared:
            short = Symbol(expression.function, *map(shortened, expression.operands))
            if used[id(expression)] == 1:
                return short
            shared[id(expression)] = Symbol("name", f"x{len(shared)}")
            lines.append(f"const real x{len(shared) - 1} = {C(short)};")
        return shared[id(expression)]

    for expression in results.values():
        count(expression)
    for place, expression in results.items():
        text = C(shortened(expression))
        lines.append(f"{place} = {text};")
    return lines


def _in_text(function: str, operands: tuple[Any, ...], within: Callable[[Any, int], str]) -> Printed:
    if function in _SIGNS:
        return f"{within(operands[0], 1)} {_SIGNS[function]} {within(operands[1], 2)}", 1
    if function == "multiply":
        return f"{within(operands[0], 3)} {within(operands[1], 3)}", 3
    if function == "divide":
        return f"{within(operands[0], 2)} / {within(operands[1], 4)}", 2
    if function == "negative":
        return f"-{within(operands[0], 2)}", 2
    if function == "power":
        return f"{within(operands[0], 5)}^{within(operands[1], 5)}", 4
    if function == "absolute":
        return f"|{within(operands[0], 0)}|", 5
    return f"{function}{_argument(operands, within, ' ', '({})')}", 4


def _argument(operands: tuple[Any, ...], within: Callable[[Any, int], str], space: str, brackets: str) -> str:
    """The operands of a function in `brackets`, or after a `space` where there is one name only."""
    if len(operands) == 1 and isinstance(operands[0], Symbol) and operands[0].function == "name":
        return space + within(operands[0], 0)
    return brackets.format(", ".join(within(operand, 0) for operand in operands))


_WORDS = {"qd": ("v", 5), "qdd": ("v'", 5), "direction": ("sgn v", 4), "load": ("torque of the rigid model", 1)}
TEXT = Notation(_in_text, lambda name: _WORDS.get(name, (name, 5)), lambda x: f"{x:g}")


def _in_latex(function: str, operands: tuple[Any, ...], within: Callable[[Any, int], str]) -> Printed:
    if function == "multiply":
        return rf"{within(operands[0], 3)} \, {within(operands[1], 3)}", 3
    if function == "divide":
        return rf"\frac{{{within(operands[0], 0)}}}{{{within(operands[1], 0)}}}", 4
    if function == "power":
        return f"{within(operands[0], 5)}^{{{within(operands[1], 0)}}}", 4
    if function == "absolute":
        return rf"\left|{within(operands[0], 0)}\right|", 5
    if function == "sqrt":
        return rf"\sqrt{{{within(operands[0], 0)}}}", 5
    if function == "hypot":
        return rf"\sqrt{{{within(operands[0], 5)}^2 + {within(operands[1], 5)}^2}}", 5
    if function in (*_SIGNS, "negative"):
        return _in_text(function, operands, within)
    word = {"minimum": "min", "maximum": "max"}.get(function, function)
    brackets = r"\left({}\right)"
    return rf"\{word}{_argument(operands, within, ' ', brackets)}", 4


_LATEX_NAMES = {
    "qd": (r"\dot q", 5),
    "qdd": (r"\ddot q", 5),
    "direction": (r"\operatorname{sgn} \dot q", 4),
    "load": (r"\tau_\mathrm{rigid}", 5),
    "rigid": (r"\tau_\mathrm{arm}", 5),
    "temperature": (r"\vartheta", 5),
    "alpha": (r"\alpha", 5),
    "torque_per_mass": (r"\tau_{1\,\mathrm{kg}}", 5),
    "rods": (r"\tau_\mathrm{rods}", 5),
    "cos_phi": (r"\cos\varphi", 4),
    "sin_phi": (r"\sin\varphi", 4),
    "dm": (r"\Delta m", 4),
    "dt": (r"\Delta t", 4),
    "L1": ("L_1", 5),
}
_AXES = {
    f"{name}[{k}]": (rf"{letter}_{axis}", 5)
    for name, letter in (("J", "J"), ("platform_velocity", r"\dot P"))
    for k, axis in enumerate("xyz")
}


def _latex_name(name: str) -> Printed:
    if found := OF_JOINT.fullmatch(name):
        text, holds = _LATEX_NAMES.get(found[1], (found[1], 5))
        return f"{text}_{{{found[2]}}}", holds
    head, _, index = name.partition("_")
    return {**_LATEX_NAMES, **_AXES}.get(name, (f"{head}_{{{index}}}" if index else head, 5))


LATEX = Notation(_in_latex, _latex_name, lambda x: f"{x:g}")
