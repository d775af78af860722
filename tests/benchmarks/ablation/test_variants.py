"""Variants: every one can be applied, wherever a name is known, and leaves nothing behind."""

import importlib
from typing import Any

import pytest

from benchmarks.ablation import variants
from ident.diagnosis.judge import improvement, judge, price
from ident.diagnosis.search import best_first


def _known() -> dict[tuple[str, str], Any]:
    """What the modules of the diagnosis know, with what is in their dictionaries and classes."""
    found: dict[tuple[str, str], Any] = {}
    for name in variants.trees():
        for key, value in vars(importlib.import_module(name)).items():
            inner = dict(value) if isinstance(value, dict) and not key.startswith("__") else None
            found[name, key] = id(value), inner, dict(vars(value)) if isinstance(value, type) else None
    return found


def test_every_variant_changes_something_and_leaves_nothing_behind() -> None:
    before, same = _known(), []
    for variant in variants.variants():
        with variants.applied(variant):
            if _known() == before:
                same.append(variant)
        assert _known() == before, variant
    # half of one is at least one
    assert all(variant.endswith("/2") for variant in same)


def test_constant_is_another_wherever_it_is_known() -> None:
    with variants.applied("judge.price.PRICE*2"):
        assert price.PRICE == best_first.PRICE == 30.0
    with variants.applied("judge.improvement.MIN_T/2"):
        assert improvement.MIN_T == judge.MIN_T == 1.75
    assert price.PRICE == best_first.PRICE == 15.0


@pytest.mark.parametrize(
    ("value", "key", "half", "double"),
    [
        (3.0, "a.LIMIT", 1.5, 6.0),
        (5, "a.COUNT", 2, 10),
        (1, "a.COUNT", 1, 2),
        (0.95, "a._LEVEL", 0.9, 0.975),
        ((1.0, 4), "a.BAND", (0.5, 2), (2.0, 8)),
        ({"x": 1.0}, "a.SHARES", {"x": 0.5}, {"x": 2.0}),
    ],
)
def test_half_and_double(value: Any, key: str, half: Any, double: Any) -> None:
    assert variants.scaled(value, key, "/2") == pytest.approx(half)
    assert variants.scaled(value, key, "*2") == pytest.approx(double)
