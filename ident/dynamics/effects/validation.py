"""Checks the description of an effect when it is loaded, before a fit would fail late or not at all."""

from collections import Counter
from collections.abc import Iterator, Sequence
from numbers import Real
from string import Formatter
from typing import Any, get_args

from ident.dynamics.effects.base import Effect, Friction, Need, Quantity, SignatureAxis

_TEXTS = ("sentence", "symptom", "causes", "remedy", "equation")
_UNITS = {"effort": "N m", "position": "rad", "turn": "turn"}


def validation_error(effect: Effect) -> str | None:
    """Return the first error in the description of `effect`, or None."""
    return next(_errors(effect), None)


def _errors(effect: Effect) -> Iterator[str]:
    for name in _TEXTS:
        text: Any = getattr(effect, name)
        if not isinstance(text, str) or not text.strip():
            yield f"{name}: a text expected, {text!r} found"
    yield from _choice_errors(effect)
    kinds: tuple[tuple[str, Any], ...] = (("parameters", effect.parameters), ("shapes", effect.shapes))
    for kind, quantities in kinds:
        if not isinstance(quantities, Sequence) or not all(isinstance(item, Quantity) for item in quantities):
            yield f"{kind}: a tuple of Quantity expected, {quantities!r} found"
            return
    yield from effect.errors()
    if not effect.parameters:
        yield "parameters: at least one Quantity expected, none found"
    if effect.local_shapes and (effect.whole_robot or not effect.linear):
        yield "local_shapes: an additive effect of single joints expected, another one found"
    names = Counter(quantity.name for quantity in (*effect.parameters, *effect.shapes))
    yield from (f"two quantities of the name {name!r} found; each needs its own" for name in names if names[name] > 1)
    for quantity in (*effect.parameters, *effect.shapes):
        yield from (f"{quantity.name}: {error}" for error in _quantity_errors(quantity))
    yield from _size_errors(effect)
    searched = effect.shapes if effect.linear else (*effect.parameters, *effect.shapes)
    for quantity in searched:
        if not quantity.initial_guesses and effect.suggest is None:
            yield f"{quantity.name}: initial_guesses (where the search for it begins) expected, none found"


def _size_errors(effect: Effect) -> Iterator[str]:
    known = {quantity.name for quantity in (*effect.parameters, *effect.shapes)} | {"norm", "largest", "turn"}
    try:
        named = {name for _, name, _, _ in Formatter().parse(effect.size) if name is not None}
    except (TypeError, ValueError):
        named = {""}
    if not named <= known:
        yield f"size: a text with no names in braces but {', '.join(sorted(known))} expected, {effect.size!r} found"


def _choice_errors(effect: Effect) -> Iterator[str]:
    if effect.axis not in get_args(SignatureAxis):
        yield f"axis: one of {', '.join(get_args(SignatureAxis))} expected, {effect.axis!r} found"
    if effect.replaces is not None and effect.replaces not in get_args(Friction):
        yield f"replaces: one of {', '.join(get_args(Friction))} expected, {effect.replaces!r} found"
    for need in effect.needs:
        if need not in get_args(Need):
            yield f"needs: any of {', '.join(get_args(Need))} expected, {need!r} found"


def _quantity_errors(quantity: Quantity) -> Iterator[str]:
    if not isinstance(quantity.name, str) or not quantity.name.isidentifier():
        yield f"a name like a variable's expected, {quantity.name!r} found"
    for field in ("unit", "meaning"):
        if not isinstance(getattr(quantity, field), str):
            yield f"{field}: a text expected, {getattr(quantity, field)!r} found"
    try:
        quantity.unit.format(**_UNITS)
    except (KeyError, ValueError, IndexError, AttributeError):
        yield f"unit: no braces but {{effort}}, {{position}} and {{turn}} expected, {quantity.unit!r} found"
    limits: Any = (quantity.lower, quantity.upper)
    guesses = quantity.initial_guesses
    if not all(isinstance(limit, Real) for limit in limits) or not quantity.lower < quantity.upper:
        yield f"lower below upper expected, {quantity.lower!r} and {quantity.upper!r} found"
    elif not isinstance(guesses, Sequence) or not all(isinstance(guess, Real) for guess in guesses):
        yield f"initial_guesses: a tuple of numbers expected, {guesses!r} found"
    elif not all(quantity.lower <= guess <= quantity.upper for guess in guesses):
        yield f"initial_guesses within {quantity.lower:g} and {quantity.upper:g} expected, {guesses!r} found"
