"""Comparison of two documents: tolerances and printed differences."""

import math
from typing import Any

import pytest

from tests.golden.cases import numbers
from tests.golden.differences import LONG, NOT_COMPARED, compare, shortened


def paths(kept: Any, actual: Any, relative: float = 1e-9) -> list[str]:
    """Paths at which the documents differ."""
    return [difference.path for difference in compare(kept, actual, relative).differences]


def test_identical_documents_are_equal() -> None:
    document = {"a": [1.5, {"b": None, "c": "name"}], "d": True, "e": math.nan}
    comparison = compare(document, document, 0.0)
    assert not comparison.differences
    assert comparison.worst == 0.0


def test_difference_within_the_tolerance_is_equal_but_counts_as_worst() -> None:
    comparison = compare({"rms": 2.0}, {"rms": 2.0 + 1e-10}, 1e-9)
    assert not comparison.differences
    assert comparison.worst == pytest.approx(5e-11, rel=1e-3)


def test_difference_beyond_the_tolerance_is_reported() -> None:
    comparison = compare({"a": [{"rms": 2.0}]}, {"a": [{"rms": 2.1}]}, 1e-9)
    (difference,) = comparison.differences
    assert str(difference) == "$.a[0].rms: 2.0 kept, 2.1 found, 0.048 apart"
    assert comparison.worst == pytest.approx(0.1 / 2.1)


def test_differences_are_relative_to_the_larger_number() -> None:
    assert compare(1.0, 2.0, 1e-9).worst == compare(2.0, 1.0, 1e-9).worst == 0.5


def test_tiny_numbers_count_as_zero() -> None:
    assert not paths({"p": 1e-128}, {"p": 1e-120})
    assert paths({"p": 1e-7}, {"p": 2e-7})


def test_numbers_of_a_list_are_relative_to_its_largest_number() -> None:
    assert not paths([1e6, 1e-5], [1e6, 1.1e-5])
    assert paths([1e6, 1.0], [1e6, 1.1]) == ["$[1]"]


@pytest.mark.parametrize(("kept", "actual"), [("stribeck", "backlash"), (True, False), (1.0, True), (None, 0.0)])
def test_names_and_types_are_compared_exactly(kept: object, actual: object) -> None:
    assert paths({"x": kept}, {"x": actual}, relative=1.0) == ["$.x"]


@pytest.mark.parametrize("number", [math.inf, math.nan])
def test_infinity_and_nan_differ_from_a_number(number: float) -> None:
    assert paths([1.0], [number], relative=10.0) == ["$[0]"]


def test_order_is_compared() -> None:
    assert paths(["a", "b"], ["b", "a"]) == ["$[0]", "$[1]"]


def test_missing_and_additional_keys_are_reported() -> None:
    differences = compare({"a": {"gone": 1}}, {"a": {"new": 1}}, 1e-9).differences
    assert [str(difference) for difference in differences] == ["$.a.gone: missing", "$.a.new: not in what was kept"]


def test_lists_of_different_length_are_compared_up_to_the_shorter_one() -> None:
    assert paths(["a", "b"], ["c"]) == ["$", "$[0]"]


@pytest.mark.parametrize("key", NOT_COMPARED)
def test_sentences_are_not_compared(key: str) -> None:
    assert not paths({key: "one"}, {key: "two"})
    assert not paths({key: "one"}, {})
    assert shortened({key: "one", "rms": 1.0}) == {"rms": 1.0}


def test_change_anywhere_in_a_thinned_list_is_reported() -> None:
    values = [float(k) for k in range(LONG + 4)]
    for k in range(len(values)):
        changed = [*values[:k], values[k] + 0.01, *values[k + 1 :]]
        assert paths(shortened(values), shortened(changed))


def test_short_lists_are_not_thinned() -> None:
    values = [float(k) for k in range(LONG)]
    assert shortened({"a": values, "b": [{"c": values}]}) == {"a": values, "b": [{"c": values}]}


def test_numbers_are_extracted_from_a_program() -> None:
    assert numbers("Curve(joint=2, of_1=x, knots=(-3.5, 1e-05), q_0=0.25)") == [2.0, -3.5, 1e-05, 0.25]
