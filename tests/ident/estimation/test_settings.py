from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.estimation import settings
from ident.estimation.settings import Meaning
from recordings.errors import BadInput


@dataclass(frozen=True)
class Some:
    """Settings of each kind."""

    size: Annotated[int, Meaning("how many", "N")] = 3
    factor: Annotated[float, Meaning("how much")] = 0.5
    order: Annotated[Literal["up", "down"], Meaning("which way")] = "up"


def create(given_values: dict[str, Any]) -> Some:
    result = settings.create(Some, given_values, "method some", "read about them")
    assert isinstance(result, Some)
    return result


@given(st.integers(-(10**9), 10**9), st.floats(-1e9, 1e9), st.sampled_from(["up", "down"]))
def test_a_value_and_its_text_are_the_same(size: int, factor: float, order: Literal["up", "down"]) -> None:
    expected = Some(size, factor, order)
    assert create({"size": size, "factor": factor, "order": order}) == expected
    assert create({"size": np.int64(size), "factor": np.float64(factor), "order": order}) == expected
    assert create(dict(settings.parse((f"N={size}", f"factor = {factor!r}", f"order={order}")))) == expected


@pytest.mark.parametrize(
    ("given_values", "message"),
    [
        ({"sice": 1}, "a setting of size, factor, order expected, 'sice' found; did you mean size"),
        ({"size": "many"}, "size: an integer expected, 'many' found"),
        ({"size": 2.5}, "size: an integer expected, 2.5 found"),
        ({"size": True}, "size: an integer expected, True found"),
        ({"factor": "nan"}, "factor: a number expected"),
        ({"factor": None}, "factor: a number expected"),
        ({"order": "sideways"}, "order: up or down expected, 'sideways' found"),
        ({"size": 1, "N": 2}, "size expected once, found twice"),
    ],
)
def test_an_unknown_name_or_a_wrong_type_is_refused(given_values: dict[str, Any], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        create(given_values)


@pytest.mark.parametrize("texts", [("size",), ("size=",), ("=3",), ("size=1", "size=2")])
def test_a_malformed_text_is_refused(texts: tuple[str, ...]) -> None:
    with pytest.raises(BadInput, match="--set"):
        settings.parse(texts)
