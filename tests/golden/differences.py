"""Compare JSON documents: numbers within a tolerance, names and order exactly, sentences not at all."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
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


def compare(kept: Any, actual: Any, relative: float) -> Comparison:
    """Compare an `actual` document with the `kept` one; `relative`: tolerance of numbers."""
    differences = list(_differences(kept, actual, "$", FLOOR))
    exceeding = tuple(difference for difference in differences if not _is_small(difference, relative))
    numbers = [difference.relative for difference in differences if math.isfinite(difference.relative)]
    return Comparison(exceeding, max(numbers, default=0.0))


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


def _is_small(difference: Difference, relative: float) -> bool:
    return 0.0 < difference.relative <= relative


def _differences(kept: Any, actual: Any, path: str, floor: float) -> Iterator[Difference]:
    if isinstance(kept, dict) and isinstance(actual, dict):
        yield from _of_objects(kept, actual, path)
    elif isinstance(kept, list) and isinstance(actual, list):
        yield from _of_lists(kept, actual, path)
    elif _is_number(kept) and _is_number(actual):
        yield from _of_numbers(kept, actual, path, floor)
    elif type(kept) is not type(actual) or kept != actual:
        yield Difference(path, f"{_short(kept)} kept, {_short(actual)} found")


def _of_objects(kept: dict[str, Any], actual: dict[str, Any], path: str) -> Iterator[Difference]:
    for key in chain(kept, (key for key in actual if key not in kept)):
        if key in NOT_COMPARED:
            continue
        place = f"{path}.{key}"
        if key not in actual:
            yield Difference(place, "missing")
        elif key not in kept:
            yield Difference(place, "not in what was kept")
        else:
            yield from _differences(kept[key], actual[key], place, FLOOR)


def _of_lists(kept: list[Any], actual: list[Any], path: str) -> Iterator[Difference]:
    if len(kept) != len(actual):
        yield Difference(path, f"{len(kept)} entries kept, {len(actual)} found")
    floor = FLOOR
    if _are_numbers(kept) and _are_numbers(actual):
        floor = max(FLOOR, FLOOR_IN_LIST * max((abs(number) for number in (*kept, *actual)), default=0.0))
    for index, (kept_entry, actual_entry) in enumerate(zip(kept, actual, strict=False)):
        yield from _differences(kept_entry, actual_entry, f"{path}[{index}]", floor)


def _of_numbers(kept: float, actual: float, path: str, floor: float) -> Iterator[Difference]:
    if kept == actual or (math.isnan(kept) and math.isnan(actual)):
        return
    size = max(abs(kept), abs(actual), floor)
    relative = abs(kept - actual) / size if math.isfinite(size) else math.inf
    relative = math.inf if math.isnan(relative) else relative
    yield Difference(path, f"{kept!r} kept, {actual!r} found, {relative:.2g} apart", relative)


def _is_number(value: Any) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _are_numbers(values: Sequence[Any]) -> TypeGuard[list[float]]:
    return bool(values) and all(_is_number(value) for value in values)


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
