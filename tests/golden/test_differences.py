"""Comparison of two documents: tolerances and printed differences."""

import math
from typing import Any

import pytest

from tests.golden.cases import numbers
from tests.golden.differences import LONG, NOT_COMPARED, compare, shortened

LIST = [float(k) for k in range(LONG + 4)]


@pytest.mark.parametrize(
    ("kept", "actual", "relative", "paths"),
    [
        (
            {"a": [1.5, {"b": None, "c": "name"}], "e": math.nan},
            {"a": [1.5, {"b": None, "c": "name"}], "e": math.nan},
            0.0,
            [],
        ),
        ({"rms": 2.0}, {"rms": 2.0 + 1e-10}, 1e-9, []),
        ({"a": [{"rms": 2.0}]}, {"a": [{"rms": 2.1}]}, 1e-9, ["$.a[0].rms: 2.0 kept, 2.1 found, 0.048 apart"]),
        ({"p": 1e-128}, {"p": 1e-120}, 1e-9, []),  # tiny numbers count as zero
        ({"p": 1e-7}, {"p": 2e-7}, 1e-9, ["$.p"]),
        ([1e6, 1e-5], [1e6, 1.1e-5], 1e-9, []),  # relative to the largest number of the list
        ([1e6, 1.0], [1e6, 1.1], 1e-9, ["$[1]"]),
        ({"x": "stribeck"}, {"x": "backlash"}, 1.0, ["$.x"]),
        ({"x": True}, {"x": False}, 1.0, ["$.x"]),
        ({"x": 1.0}, {"x": True}, 1.0, ["$.x"]),
        ({"x": None}, {"x": 0.0}, 1.0, ["$.x"]),
        ([1.0], [math.inf], 10.0, ["$[0]"]),
        ([1.0], [math.nan], 10.0, ["$[0]"]),
        (["a", "b"], ["b", "a"], 1e-9, ["$[0]", "$[1]"]),
        (["a", "b"], ["c"], 1e-9, ["$[0]", "$[1]: missing"]),
        ({"x": [], "y": {}}, {"x": [1]}, 1e-9, ["$.x: missing", "$.y: missing", "$.x[0]: not in what was kept"]),
        ({"a": {"gone": 1}}, {"a": {"new": 1}}, 1e-9, ["$.a.gone: missing", "$.a.new: not in what was kept"]),
        ({"why": "one", "x": 1}, {"x": 1}, 1e-9, []),  # sentences are not compared
    ],
)
def test_differences(kept: Any, actual: Any, relative: float, paths: list[str]) -> None:
    found = [str(difference) for difference in compare(kept, actual, relative).differences]
    assert len(found) == len(paths)
    assert all(text == path or text.startswith(f"{path}:") for text, path in zip(found, paths, strict=True))


def test_worst_difference_is_relative_to_the_larger_number_within_the_tolerance_too() -> None:
    assert compare(1.0, 2.0, 1e-9).worst == compare(2.0, 1.0, 1e-9).worst == 0.5
    assert compare(2.0, 2.0 + 1e-10, 1e-9).worst == pytest.approx(5e-11, rel=1e-3)


def test_long_lists_are_thinned_so_that_any_change_shows_and_sentences_are_left_out() -> None:
    for k in range(len(LIST)):
        changed = [*LIST[:k], LIST[k] + 0.01, *LIST[k + 1 :]]
        assert compare(shortened(LIST), shortened(changed), 1e-9).differences
    assert shortened({"a": LIST[:LONG], **dict.fromkeys(NOT_COMPARED, "one")}) == {"a": LIST[:LONG]}


def test_numbers_are_extracted_from_a_program() -> None:
    assert numbers("Curve(joint=2, of_1=x, knots=(-3.5, 1e-05), q_0=0.25)") == [2.0, -3.5, 1e-05, 0.25]
