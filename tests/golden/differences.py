"""Compare JSON documents: numbers within a tolerance, names and order exactly, sentences not at all."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeGuard

NOT_COMPARED = {
    "why": "a sentence",
    "sentence": "a sentence",
    "where": "sentences, made of numbers that are compared elsewhere",
    "warnings": "sentences",
    "symptom": "a sentence of the library",
    "causes": "a sentence of the library",
    "remedy": "a sentence of the library",
    "meaning": "words of the library",
    "held_out": "a sentence with names of files; what was held out shows in the errors",
    "cutoff": "a sentence; the frequency itself is `bandwidth`",
    "command": "a command line with paths",
    "file": "a path",
    "software": "the version, which is not a result",
}
"""Keys that are not compared anywhere in a document, and why. Nothing else is: there are no dates and no timings."""

FLOOR = 1e-6
"""Smallest scale of a relative difference: smaller numbers are rounding errors of zero."""
FLOOR_IN_LIST = 1e-3
"""Smallest scale in a list of numbers, relative to its largest number."""
LONG = 16
"""Longer lists of numbers are thinned before they are stored."""
_EVERY = 3


@dataclass(frozen=True)
class Difference:
    """One difference between two documents."""

    path: str
    what: str
    relative: float = 0.0
    """Relative difference of two numbers; infinite if one of them is not finite."""

    def __str__(self) -> str:
        return f"{self.path}: {self.what}"


@dataclass(frozen=True)
class Comparison:
    """All differences between two documents."""

    differences: tuple[Difference, ...]
    worst: float
    """Largest relative difference of numbers, also of those within the tolerance."""


_Leaf = tuple[Any, float]
"""A value that is no object and no list, or an empty one, and the smallest scale of a relative difference from it."""


def compare(kept: Any, actual: Any, relative: float) -> Comparison:
    """Compare an `actual` document with the `kept` one; `relative`: tolerance of numbers."""
    before, after = dict(_leaves(kept)), dict(_leaves(actual))
    differences = [each for path in before | after for each in _differences(path, before.get(path), after.get(path))]
    exceeding = tuple(each for each in differences if not 0.0 < each.relative <= relative)
    finite = [each.relative for each in differences if math.isfinite(each.relative)]
    return Comparison(exceeding, max(finite, default=0.0))


def shortened(document: Any) -> Any:
    """Document without the keys that are not compared and with thinned lists of numbers."""
    if isinstance(document, dict):
        return {key: shortened(value) for key, value in document.items() if key not in NOT_COMPARED}
    if isinstance(document, list):
        return _thinned(document) if _are_numbers(document) else [shortened(value) for value in document]
    return document


def _thinned(numbers: list[float]) -> Any:
    """Every third number, and means that change with the other numbers."""
    if len(numbers) <= LONG:
        return numbers
    count = len(numbers)
    mean = math.fsum(numbers) / count
    size = math.fsum(map(abs, numbers)) / count
    return {"count": count, "mean": mean, "mean_size": size, "some": numbers[::_EVERY]}


def _leaves(document: Any, path: str = "$", floor: float = FLOOR) -> Iterator[tuple[str, _Leaf]]:
    """Yield the path and leaf of each value that is compared; `floor`: the smallest scale."""
    if isinstance(document, dict) and document:
        for key, value in document.items():
            if key not in NOT_COMPARED:
                yield from _leaves(value, f"{path}.{key}")
    elif isinstance(document, list) and document:
        floor = max(FLOOR, FLOOR_IN_LIST * max(map(abs, document))) if _are_numbers(document) else FLOOR
        for index, value in enumerate(document):
            yield from _leaves(value, f"{path}[{index}]", floor)
    else:
        yield path, (document, floor)


def _differences(path: str, kept: _Leaf | None, actual: _Leaf | None) -> Iterator[Difference]:
    """Yield the difference of two leaves, if there is one; None: there is no leaf of this `path`."""
    if kept is None or actual is None:
        yield Difference(path, "missing" if kept else "not in what was kept")
        return
    (before, floor), (after, other_floor) = kept, actual
    if _is_number(before) and _is_number(after):
        if not (before == after or (math.isnan(before) and math.isnan(after))):
            size = max(abs(before), abs(after), floor, other_floor)
            apart = abs(before - after) / size if math.isfinite(before) and math.isfinite(after) else math.inf
            yield Difference(path, f"{before!r} kept, {after!r} found, {apart:.2g} apart", apart)
    elif type(before) is not type(after) or before != after:
        yield Difference(path, f"{_short(before)} kept, {_short(after)} found")


def _is_number(value: Any) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _are_numbers(values: Sequence[Any]) -> TypeGuard[list[float]]:
    return bool(values) and all(_is_number(value) for value in values)


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
