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
    torque_per_mass, rods     the joint's torque for 1 kg at the platform or tool, and for rods of 1 kg
    balls_dry, balls_viscous  the same for friction of 1 N m, and of 1 N m s/rad, in each ball of a delta's rods
    q1, qd2, qdd3, ...        q, qd, qdd, direction and rigid of the joint with this number, whichever has the effect
"""

import functools
import inspect
import operator
import re
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

Formula = Callable[..., Any]
Printed = tuple[str, int]
"""A text, and how strongly its parts hold together: 1 sums, 2 quotients and signs, 3 products, 4 powers and
functions, 5 names."""
Rule = tuple[str, tuple[int, ...], int]
"""How to print a function: a text with a place for each operand, how strongly what stands there has to hold together,
and how strongly the whole does."""

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


@dataclass(frozen=True)
class Notation:
    """What prints expressions; see `C`, `TEXT` and `LATEX`."""

    rules: Mapping[str, Rule]
    """How to print a function, by its name in NumPy; "square" is a power of 2."""
    call: Callable[[str, bool], Printed]
    """What prints a function without a rule: the text around its operands, given whether these are one name alone."""
    name: Callable[[str], Printed]
    number: Callable[[float], str]

    def __call__(self, expression: Any) -> str:
        """Print the `expression`."""
        return self._print(expression)[0]

    def _print(self, expression: Any) -> Printed:
        if not isinstance(expression, Symbol):
            return self.number(expression), 5 if expression >= 0 else 3
        function, operands = expression.function, expression.operands
        if function == "name":
            return self.name(operands[0])
        squared = function == "power" and _is(operands[1], 2)
        if rule := (squared and self.rules.get("square")) or self.rules.get(function):
            text, strengths, holds = rule
            return text.format(*map(self._within, operands, strengths)), holds
        alone = len(operands) == 1 and isinstance(operands[0], Symbol) and operands[0].function == "name"
        text, holds = self.call(function, alone)
        return text.format(", ".join(map(self, operands))), holds

    def _within(self, expression: Any, strength: int) -> str:
        """Print a part of an expression, in brackets where it holds together less than `strength`."""
        text, holds = self._print(expression)
        return text if holds >= strength else f"({text})"


SUMS: dict[str, Rule] = {"add": ("{} + {}", (1, 2), 1), "subtract": ("{} - {}", (1, 2), 1)}
ARITHMETIC: dict[str, Rule] = SUMS | {
    "multiply": ("{} * {}", (2, 3), 2),
    "divide": ("{} / {}", (2, 3), 2),
    "negative": ("-{}", (3,), 3),
}
"""As programming languages write it."""
_C_NAMES = {"absolute": "fabs", "minimum": "fmin", "maximum": "fmax", "power": "pow"}
_C_QUANTITIES = {"J": "J[i]", "platform_velocity": "velocity"}


def _c_name(name: str) -> Printed:
    head, bracket, index = name.partition("[")
    return _C_QUANTITIES.get(head, head) + bracket + index, 5


C = Notation(
    ARITHMETIC | {"square": ("{0} * {0}", (4,), 2)},
    lambda function, alone: (f"{_C_NAMES.get(function, function)}({{}})", 5),
    _c_name,
    lambda x: repr(x if isinstance(x, int) else float(x)),
)


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
        lines.append(f"{place} = {C(shortened(expression))};")
    return lines


_TEXT_RULES: dict[str, Rule] = SUMS | {
    "multiply": ("{} {}", (3, 3), 3),
    "divide": ("{} / {}", (2, 4), 2),
    "negative": ("-{}", (2,), 2),
    "power": ("{}^{}", (5, 5), 4),
    "absolute": ("|{}|", (0,), 5),
}
_WORDS = {"qd": ("v", 5), "qdd": ("v'", 5), "direction": ("sgn v", 4), "load": ("torque of the rigid model", 1)}
TEXT = Notation(
    _TEXT_RULES,
    lambda function, alone: (function + (" {}" if alone else "({})"), 4),
    lambda name: _WORDS.get(name, (name, 5)),
    lambda x: f"{x:g}",
)

_LATEX_RULES: dict[str, Rule] = _TEXT_RULES | {
    "multiply": (r"{} \, {}", (3, 3), 3),
    "divide": (r"\frac{{{}}}{{{}}}", (0, 0), 4),
    "power": ("{}^{{{}}}", (5, 0), 4),
    "absolute": (r"\left|{}\right|", (0,), 5),
    "sqrt": (r"\sqrt{{{}}}", (0,), 5),
    "hypot": (r"\sqrt{{{}^2 + {}^2}}", (5, 5), 5),
}
_LATEX_FUNCTIONS = {"minimum": "min", "maximum": "max"}
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
    "balls_dry": (r"\tau_\mathrm{dry}", 5),
    "balls_viscous": (r"\tau_\mathrm{viscous}", 5),
    "mu": (r"\mu", 5),
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


LATEX = Notation(
    _LATEX_RULES,
    lambda function, alone: (
        "\\" + _LATEX_FUNCTIONS.get(function, function) + (" {}" if alone else r"\left({}\right)"),
        4,
    ),
    _latex_name,
    lambda x: f"{x:g}",
)
