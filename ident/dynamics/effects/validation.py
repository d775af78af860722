"""What an effect says of itself, checked before anything is done with it: a fit would fail late, or not at all."""

from collections import Counter
from collections.abc import Iterator, Sequence
from numbers import Real
from typing import Any, get_args

from ident.dynamics.effects.base import Additive, Effect, Quantity, SignatureAxis

_TEXTS = ("sentence", "symptom", "causes", "remedy", "equation")
_UNITS = {"effort": "N m", "position": "rad"}


def validation_error(effect: Effect) -> str | None:
    """What is wrong with the `effect`, the first thing of it; None if nothing is."""
    return next(_all(effect), None)


def _all(effect: Effect) -> Iterator[str]:
    for name in _TEXTS:
        text: Any = getattr(effect, name)
        if not isinstance(text, str) or not text.strip():
            yield f"{name}: a text expected, {text!r} found"
    if effect.axis not in get_args(SignatureAxis):
        yield f"axis: one of {', '.join(get_args(SignatureAxis))} expected, {effect.axis!r} found"
    own = effect.coefficients if isinstance(effect, Additive) else getattr(effect, "parameters", ())
    kinds: list[tuple[str, Any]] = [("shapes", effect.shapes)]
    kinds.insert(0, ("coefficients" if isinstance(effect, Additive) else "parameters", own))
    for kind, quantities in kinds:
        if not isinstance(quantities, Sequence) or not all(isinstance(one, Quantity) for one in quantities):
            yield f"{kind}: a tuple of Quantity expected, {quantities!r} found"
            return
    if not own:
        yield f"{kinds[0][0]}: at least one Quantity expected, none found"
    names = Counter(one.name for one in (*own, *effect.shapes))
    yield from (f"two quantities of the name {name!r} found; each needs its own" for name in names if names[name] > 1)
    for one in (*own, *effect.shapes):
        yield from (f"{one.name}: {found}" for found in _quantity(one))
    needed = effect.shapes if isinstance(effect, Additive) else (*own, *effect.shapes)
    for one in needed:
        if not one.initial_guesses and effect.suggest is None:
            yield f"{one.name}: starts (where the search for it begins) expected, none found"


def _quantity(one: Quantity) -> Iterator[str]:
    if not isinstance(one.name, str) or not one.name.isidentifier():
        yield f"a name like a variable's expected, {one.name!r} found"
    for what in ("unit", "meaning"):
        if not isinstance(getattr(one, what), str):
            yield f"{what}: a text expected, {getattr(one, what)!r} found"
    try:
        one.unit.format(**_UNITS)
    except (KeyError, ValueError, IndexError, AttributeError):
        yield f"unit: no braces but {{effort}} and {{position}} expected, {one.unit!r} found"
    limits: Any = (one.lower, one.upper)
    if not all(isinstance(limit, Real) for limit in limits) or not one.lower < one.upper:
        yield f"lower below upper expected, {one.lower!r} and {one.upper!r} found"
    elif not isinstance(one.initial_guesses, Sequence) or not all(
        isinstance(start, Real) for start in one.initial_guesses
    ):
        yield f"starts: a tuple of numbers expected, {one.initial_guesses!r} found"
    elif not all(one.lower <= start <= one.upper for start in one.initial_guesses):
        yield f"starts within {one.lower:g} and {one.upper:g} expected, {one.initial_guesses!r} found"
