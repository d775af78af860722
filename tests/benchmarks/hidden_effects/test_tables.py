"""Criterion for a missed requirement."""

import pytest

from benchmarks.hidden_effects.tables import Figure


@pytest.mark.parametrize(
    ("hits", "required", "missed"),
    [
        ([True] * 9 + [False], 97, False),  # one of ten may be chance
        ([True] * 6 + [False] * 4, 97, True),
        ([False] * 3, 98, True),
        ([True] * 382 + [False] * 26, 95, False),
        ([True] * 360 + [False] * 48, 95, True),
        ([True, False], 100, True),
        ([False] * 10, None, False),
        ([], 97, False),
    ],
)
def test_only_a_significant_shortfall_counts_as_clearly_missed(
    hits: list[bool], required: float | None, missed: bool
) -> None:
    assert Figure("of something", hits, required).clearly_missed is missed


def test_any_share_below_the_required_one_is_marked_as_missed() -> None:
    assert Figure("of something", [True, False], 97).line.endswith("50.0 % of 2   required 97 %   MISSED")
    assert Figure("of something", [True, True], 97).line.endswith("100.0 % of 2   required 97 %")
    assert Figure("of something", [], 97).line.endswith("no cases")
