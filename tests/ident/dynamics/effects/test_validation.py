"""Descriptions of effects are checked when they are loaded."""

import re
from dataclasses import replace
from typing import Any

import pytest

from ident.dynamics.effects.base import Quantity
from ident.dynamics.effects.library import library
from ident.dynamics.effects.validation import validation_error


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"sentence": 3}, "sentence: a text expected, 3 found"),
        ({"causes": " "}, "causes: a text expected"),
        ({"formula": lambda speed: speed, "equation": "a v"}, "formula: arguments out of q, qd, .* 'speed' found"),
        ({"size": "{speed}"}, "size: a text with no names in braces but a, largest, norm, turn, v_s expected"),
        ({"size": "{a"}, "size: a text"),
        ({"size": 3}, "size: a text"),
        ({"axis": "colour"}, "axis: one of position, velocity"),
        ({"replaces": "friction"}, "replaces: one of c_v, c_c expected, 'friction' found"),
        ({"needs": ("luck",)}, "needs: any of temperature, no temperature, both directions expected, 'luck' found"),
        ({"parameters": ()}, "at least one Quantity expected"),
        ({"parameters": ("a",)}, "parameters: a tuple of Quantity expected"),
        ({"local_shapes": True, "whole_robot": True}, "local_shapes: an additive effect of single joints expected"),
        ({"suggest": None}, "v_s: initial_guesses .* expected, none found"),
    ],
)
def test_an_error_in_an_effect_is_named(changed: dict[str, Any], message: str) -> None:
    effect = library()["stribeck"]
    shape = replace(effect.shapes[0], initial_guesses=())
    assert_matches(validation_error(replace(effect, shapes=(shape,), **changed)), message)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"unit": "{foo}"}, r"a: unit: no braces but \{effort\}, \{position\} and \{turn\} expected"),
        ({"unit": "{effort"}, "a: unit"),
        ({"name": "a b"}, "a name like a variable's expected"),
        ({"name": "v_s"}, "two quantities of the name 'v_s'"),
        ({"lower": 0.5, "upper": 0.02}, "a: lower below upper expected, 0.5 and 0.02 found"),
        ({"initial_guesses": "abc"}, "a: initial_guesses: a tuple of numbers expected"),
        ({"lower": 0.0, "upper": 1.0, "initial_guesses": (2.0,)}, "a: initial_guesses within 0 and 1 expected"),
        ({"meaning": None}, "a: meaning: a text expected"),
    ],
)
def test_an_error_in_a_quantity_is_named(changed: dict[str, Any], message: str) -> None:
    coefficient = Quantity(**({"name": "a", "unit": "1", "meaning": "something"} | changed))
    assert_matches(validation_error(replace(library()["stribeck"], parameters=(coefficient,))), message)


def assert_matches(error: str | None, message: str) -> None:
    assert error
    assert re.search(message, error)
