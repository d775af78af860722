"""Watching: results stay what they are, and it is known which other constants would change them."""

import ast
from typing import Any

import pytest

from benchmarks.ablation import watching

MODULE = '''
"""A module."""
LIMIT = 1.0
COUNT = 2
UNUSED = 3.0


def above(x):
    return x > LIMIT

def between(x):
    return 0 < x < LIMIT

def kept(x):
    return (y := x + 1) < LIMIT, y

def smallest(x):
    return min(x, LIMIT)

def first(items):
    return items[:COUNT]

def enough(items):
    return sum(item > LIMIT for item in items) >= COUNT

def price(x):
    return x + LIMIT, f"at {LIMIT:g}"

class Judge:
    def accepts(self, x):
        return x > LIMIT and x > COUNT * LIMIT
'''


@pytest.fixture
def module(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    monkeypatch.setattr(watching, "NEAR", set())
    monkeypatch.setattr(watching, "USED", set())
    names: dict[str, Any] = {"_watch": watching.watch, "_use": watching.use}
    exec(compile(watching.rewritten("m", ast.parse(MODULE)), "m", "exec"), names)
    return names


@pytest.mark.parametrize(
    ("function", "argument", "result", "near"),
    [
        ("above", 0.4, False, set()),
        ("above", 0.6, False, {"LIMIT/2"}),
        ("above", 1.9, True, {"LIMIT*2"}),
        ("above", 2.1, True, set()),
        ("between", 0.6, True, {"LIMIT/2"}),
        ("kept", 0.5, (False, 1.5), {"LIMIT*2"}),
        ("smallest", 0.4, 0.4, set()),
        ("smallest", 3.0, 1.0, {"LIMIT/2", "LIMIT*2"}),
        ("first", [7], [7], set()),
        ("first", [7, 8, 9], [7, 8], {"COUNT/2", "COUNT*2"}),
        ("enough", [1.5, 0.1], False, {"COUNT/2"}),
        ("enough", [1.5, 0.8], False, {"COUNT/2", "LIMIT/2"}),
        ("price", 1.0, (2.0, "at 1"), set()),
    ],
)
def test_constants_within_a_factor_of_two_are_near(
    module: dict[str, Any], function: str, argument: Any, result: Any, near: set[str]
) -> None:
    assert module[function](argument) == result
    assert {f"m.{each}" for each in near} == watching.NEAR


def test_constant_outside_of_comparisons_is_used(module: dict[str, Any]) -> None:
    module["price"](1.0)
    assert {"m.LIMIT"} == watching.USED
