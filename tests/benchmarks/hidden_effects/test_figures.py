"""Shares with intervals, and the criterion for a missed requirement."""

import pytest

from benchmarks.hidden_effects.figures import Figure, figures
from tests.benchmarks.hidden_effects.test_scoring import judgement_of


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


@pytest.mark.parametrize(("hits", "missed"), [(95, False), (99, False), (300, True)])
def test_share_above_the_limit_is_missed_too(hits: int, missed: bool) -> None:
    figure = Figure("of something", [True] * hits + [False] * (hits // 20 if not missed else 0), 93, 97)
    assert figure.clearly_missed is missed
    assert figure.requirement == "93-97 %"


def test_share_is_printed_with_its_wilson_interval() -> None:
    # Newcombe, Statistics in Medicine 17 (1998) 857, Table I: 81 of 263 is 0.2553 to 0.3662.
    assert Figure("of something", [True] * 81 + [False] * 182).cell == "30.8 % (25.5-36.6) of 263"
    assert Figure("of something", []).cell == "no cases"


def test_any_share_outside_of_the_required_ones_is_marked() -> None:
    assert Figure("of something", [True, False], 97).cell.endswith("of 2 !")
    assert Figure("of something", [True, True], 93, 97).cell.endswith("of 2 !")
    assert Figure("of something", [True, True], 97).cell.endswith("of 2")


def test_effect_named_where_only_unknown_structure_is_hidden_is_a_false_name() -> None:
    false = judgement_of("outside", ("hose_drag",), "unknown-structure", {"stribeck": []})
    silent = judgement_of("outside", ("hose_drag",), "unknown-structure", {"rod_inertia": []})
    hits = {figure.criterion.strip(): figure.hits for figure in figures([false, silent])}
    assert hits["no effect named"] == [False, True]
