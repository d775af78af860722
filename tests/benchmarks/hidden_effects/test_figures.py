"""Shares with intervals, and the criterion for a missed requirement."""

import pytest

from benchmarks.hidden_effects.figures import Figure, figures
from tests.benchmarks.hidden_effects.test_scoring import judgement_of


def test_share_is_printed_with_its_wilson_interval() -> None:
    # Newcombe, Statistics in Medicine 17 (1998) 857, Table I: 81 of 263 is 0.2553 to 0.3662.
    assert Figure("of something", [True] * 81 + [False] * 182).cell == "30.8 % (25.5-36.6) of 263"
    assert Figure("of something", []).cell == "no cases"


def test_effect_named_where_only_unknown_structure_is_hidden_is_a_false_name() -> None:
    false = judgement_of("outside", ("hose_drag",), "unknown-structure", {"stribeck": []})
    silent = judgement_of("outside", ("hose_drag",), "unknown-structure", {"rod_inertia": []})
    hits = {figure.criterion.strip(): figure.hits for figure in figures([false, silent])}
    assert hits["no effect named"] == [False, True]


@pytest.mark.parametrize(
    ("hits", "of", "required", "marked", "clearly"),
    [
        (9, 10, (97, 100), True, False),  # one of ten may be chance
        (6, 10, (97, 100), True, True),
        (0, 3, (98, 100), True, True),
        (382, 408, (95, 100), True, False),
        (360, 408, (95, 100), True, True),
        (1, 2, (100, 100), True, True),
        (2, 2, (97, 100), False, False),
        (0, 10, (None, 100), False, False),
        (0, 0, (97, 100), False, False),
        (95, 99, (93, 97), False, False),
        (99, 103, (93, 97), False, False),
        (300, 300, (93, 97), True, True),
    ],
)
def test_share_outside_of_the_required_ones_is_marked_and_clearly_missed_if_it_is_no_chance(
    hits: int, of: int, required: tuple[float | None, float], marked: bool, clearly: bool
) -> None:
    figure = Figure("of something", [True] * hits + [False] * (of - hits), *required)
    assert (figure.cell.endswith("!"), figure.clearly_missed) == (marked, clearly)
