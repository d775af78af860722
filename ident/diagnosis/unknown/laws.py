"""The laws that a proposed formula is made of: products of what mechanics knows, as effects that can be fitted.

A law is what drives a torque, what it varies with, or the product of both: friction or inertia that depends on an
angle, a spring that engages beyond a stop, a cable between two joints. Every coefficient has a unit; arguments of
functions are made dimensionless by shapes whose bounds follow from the recorded motion.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

import numpy as np

from ident.diagnosis.search.selection import WIDTH
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity
from ident.dynamics.effects.periodogram import MAX_PHASE, highest_in_band, highest_peaks
from ident.dynamics.effects.quantities import quantity
from ident.dynamics.effects.written_formula import WrittenFormula
from recordings.recording import Floats

NAMES = "abcdef"
"""Of the coefficients; a formula has at most so many."""
_QUANTILES = (0.1, 0.4, 0.6, 0.9)
"""Of a variable, where a law may begin."""
_ORDERS = (1.0, 2.0, 3.0, 4.0, 6.0)
"""Periods per turn of the waves that are tried."""
_SHARES = (0.03, 0.08, 0.2, 0.5, 1.0)
"""Of the largest speed and of the duration: characteristic speeds and times that are tried."""

Unit = tuple[int, int, int]
"""Powers of torque, position and time."""


@dataclass(frozen=True)
class Law:
    """A product of factors, or one of them."""

    texts: tuple[str, ...]
    """The torque per unit of each coefficient: sine and cosine of a wave have their own."""
    unit: Unit = (0, 0, 0)
    """Of the texts."""
    shapes: tuple[Quantity, ...] = ()
    wave_over: str = ""
    """Variable of a wave whose order a spectrum may suggest."""
    drive: str = ""
    """What the wave is multiplied by."""

    def times(self, other: "Law") -> "Law":
        """The product with the law `other`."""
        texts = tuple(f"{first} * {second}" for first, second in product(self.texts, other.texts))
        unit = tuple(first + second for first, second in zip(self.unit, other.unit, strict=True))
        return Law(texts, unit, (*self.shapes, *other.shapes), other.wave_over, self.texts[0])  # type: ignore[arg-type]

    def with_values(self, values: Mapping[str, float]) -> "Law":
        """The law with the `values` of its shapes as their initial guesses."""
        shapes = tuple(replace(shape, initial_guesses=(float(values[shape.name]),)) for shape in self.shapes)
        return replace(self, shapes=shapes)

    def renamed(self, old: str, new: str) -> "Law":
        """The law with another name of a shape, or with a number in its place."""
        texts = tuple(re.sub(rf"\b{old}\b", new, text) for text in self.texts)
        shapes = (replace(shape, name=new) if shape.name == old else shape for shape in self.shapes)
        return replace(self, texts=texts, shapes=tuple(each for each in shapes if each.name.isidentifier()))

    @property
    def coefficient_unit(self) -> str:
        """Of its coefficients, as in `Quantity.unit`."""
        powers = {"{effort}": 1 - self.unit[0], "{position}": -self.unit[1], "s": -self.unit[2]}
        above, below = ([_power(name, abs(n)) for name, n in powers.items() if n * sign > 0] for sign in (1, -1))
        return "/".join([" ".join(above) or "1", *([" ".join(below)] if below else [])])


def _power(name: str, exponent: int) -> str:
    return name if exponent == 1 else f"{name}^{exponent}"


def effect_of(laws: Sequence[Law], joints: Sequence[int]) -> Additive:
    """The sum of `laws` as an effect on `joints` (from 0)."""
    units = [law.coefficient_unit for law in laws for _ in law.texts]
    suggests = len(laws) == 1 and bool(laws[0].wave_over) and laws[0].drive in ("", "load")
    return Additive(
        sentence="A law that was found in the residual.",
        symptom="See the formula.",
        causes="not known",
        remedy="look at the part itself",
        axis="position",
        joints=tuple(joints),
        formula=WrittenFormula(*(text for law in laws for text in law.texts)),
        parameters=tuple(
            Quantity(name=name, unit=unit, meaning="coefficient") for name, unit in zip(NAMES, units, strict=False)
        ),
        shapes=tuple(shape for law in laws for shape in law.shapes),
        suggest=partial(_suggest, laws[0]) if suggests else None,
        multistart=2,
    )


def laws(inputs: Sequence[EffectInputs], joints: Sequence[int], others: Sequence[int]) -> dict[str, Law]:
    """Laws by their text that torque of the `joints` may follow, if it depends on the motion of `others`, too.

    inputs: motion of the training recordings. Joints are counted from 0.
    """
    others = [joint for joint in others if list(joints) != [joint]]
    drives, foreign = _drives(inputs, joints), list(_foreign(inputs, others))
    modulators = [*_modulators(inputs, joints), *foreign]
    pairs = [*product(drives, modulators), *product(_of_position("q", inputs, joints), foreign)]
    products = [first.times(second) for first, second in pairs if not (first.wave_over and second.wave_over)]
    return {" + ".join(law.texts): law for law in (*drives, *modulators, *_between(joints, others), *products)}


def _drives(inputs: Sequence[EffectInputs], joints: Sequence[int]) -> list[Law]:
    speed = max(float(np.nanmax(np.abs(each.motion.velocity[:, list(joints)]))) for each in inputs)
    v = _shape("v", "{position}/s", "characteristic speed", speed, 3.0)
    return [
        Law(("direction",)),
        Law(("qd",), (0, 1, -1)),
        Law(("qd * abs(qd)",), (0, 2, -2)),
        Law(("tanh(qd / v)",), shapes=(v,)),
        Law(("qd / (1 + (qd / v) ** 2)",), (0, 1, -1), (v,)),
        Law(("exp(-abs(qd) / v) * direction",), shapes=(v,)),
        Law(("qdd",), (0, 1, -2)),
        Law(("sign(qdd)",)),
        Law(("load",), (1, 0, 0)),
    ]


def _modulators(inputs: Sequence[EffectInputs], joints: Sequence[int]) -> Iterator[Law]:
    yield from _of_position("q", inputs, joints)
    yield from (Law(("abs(qdd)",), (0, 1, -2)), Law(("abs(load)",), (1, 0, 0)), Law(("abs(qd)",), (0, 1, -1)))
    time = _shape("T", "s", "time constant", max(float(each.time.max()) for each in inputs), 2.0)
    yield from (
        Law(("t",), (0, 0, 1)),
        Law(("exp(-t / T)",), shapes=(time,)),
        Law(("(1 - exp(-t / T))",), shapes=(time,)),
    )


def _foreign(inputs: Sequence[EffectInputs], others: Sequence[int]) -> Iterator[Law]:
    """What the motion of each of the joints `others` may do to another one."""
    for joint in others:
        k = joint + 1
        yield from _of_position(f"q{k}", inputs, [joint])
        yield from (Law((f"qd{k}",), (0, 1, -1)), Law((f"abs(qd{k})",), (0, 1, -1)), Law((f"direction{k}",)))
        yield Law((f"qdd{k}",), (0, 1, -2))


def _between(joints: Sequence[int], others: Sequence[int]) -> Iterator[Law]:
    """Springs and dampers between one of the `joints` and one of the `others`."""
    for first, second in product(joints, others):
        if first < second or (second not in joints and first != second):
            i, k = first + 1, second + 1
            yield from (Law((f"(q{i} - q{k})",), (0, 1, 0)), Law((f"(qd{i} - qd{k})",), (0, 1, -1)))


def _of_position(x: str, inputs: Sequence[EffectInputs], joints: Sequence[int]) -> Iterator[Law]:
    """What may depend on the position `x`, which is that of `joints`: proportional, a wave, or beyond an angle."""
    values = np.concatenate([_values(x, each)[:, list(joints) if x == "q" else slice(1)] for each in inputs])
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    travel, number = max(high - low, 1e-9), x[1:]
    orders = sorted({*_ORDERS, *(np.pi / travel * share for share in (1.0, 2.0, 4.0))})
    n = Quantity(
        name=f"n{number}",
        unit="1/{position}",
        meaning="order of the wave",
        lower=0.3 * np.pi / travel,
        upper=MAX_PHASE / travel,
        initial_guesses=tuple(orders),
    )
    begin = Quantity(
        name=f"s{number}",
        unit="{position}",
        meaning="where it begins or ends",
        lower=low,
        upper=high,
        initial_guesses=tuple(np.nanquantile(values, _QUANTILES).tolist()),
    )
    yield Law((x,), (0, 1, 0))
    yield Law((f"sin({n.name} * {x})", f"cos({n.name} * {x})"), shapes=(n,), wave_over=x)
    yield Law((f"maximum({x} - {begin.name}, 0)",), (0, 1, 0), (begin,))
    yield Law((f"maximum({begin.name} - {x}, 0)",), (0, 1, 0), (begin,))


def _shape(name: str, unit: str, meaning: str, largest: float, factor: float) -> Quantity:
    """A characteristic value of what reaches up to `largest`: at most `factor` times as much."""
    return Quantity(
        name=name,
        unit=unit,
        meaning=meaning,
        lower=_SHARES[0] * largest / 3,
        upper=factor * largest,
        initial_guesses=tuple(share * largest for share in _SHARES),
    )


def _values(x: str, inputs: EffectInputs) -> Floats:
    return np.broadcast_to(quantity(x, inputs), inputs.motion.position.shape)


def _suggest(wave: Law, inputs: EffectInputs, residual: Floats) -> list[dict[str, float]]:
    """Orders at which the spectrum of the `residual` (n, dof) over the variable of the `wave` has its peaks."""
    x, name = _values(wave.wave_over, inputs), wave.shapes[-1].name
    signal = residual * (quantity(wave.drive, inputs) if wave.drive else 1.0)
    travel = float(np.nanmax(np.nanmax(x, axis=0) - np.nanmin(x, axis=0)))
    highest = min(MAX_PHASE / travel, highest_in_band(np.abs(inputs.motion.velocity), inputs.bandwidth))
    orders = np.arange(2 * np.pi / travel, highest, 1.0 / travel)
    return [{name: order} for order in highest_peaks(x, signal, orders, WIDTH)]
