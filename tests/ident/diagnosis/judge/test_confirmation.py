"""The rule when an effect counts as confirmed."""

from dataclasses import replace

import pytest

from ident.diagnosis.judge.confirmation import MIN_SHARE, MIN_T, is_small, is_supported
from ident.diagnosis.judge.equivalence import MIN_DECISIVE_REDUCTION, MIN_DECISIVE_SHARE, is_decisive
from ident.diagnosis.judge.improvement import Improvement


def improvement(
    t: float = 10.0, low: float = 0.5, share: float = 0.8, reduction: float = 1.0, remaining: float = 0.1
) -> Improvement:
    return Improvement(share, (low, 1.0), t, reduction, remaining)


@pytest.mark.parametrize(("t", "supported"), [(MIN_T + 0.1, True), (MIN_T - 0.1, False), (-10.0, False)])
def test_support_needs_many_blocks(t: float, supported: bool) -> None:
    assert is_supported(improvement(t=t)) is supported


@pytest.mark.parametrize(("remaining", "supported"), [(0.5, True), (50.0, False)])
def test_ratio_of_the_blocks_counts_unless_the_improvement_is_a_trifle(remaining: float, supported: bool) -> None:
    """A few blocks at reversals dominate the mean squares; the ratio in most of them tells the effect."""
    assert is_supported(replace(improvement(t=2.5, remaining=remaining), t_of_ratio=6.7)) is supported


@pytest.mark.parametrize(("taken", "small"), [(MIN_SHARE - 0.01, True), (MIN_SHARE + 0.01, False)])
def test_trifle_is_measured_by_what_is_missing(taken: float, small: bool) -> None:
    assert is_small(improvement(reduction=taken, remaining=1 - taken)) is small
    assert not is_small(improvement(reduction=0.1, remaining=-0.2))  # nothing is left above the floor


@pytest.mark.parametrize(
    ("changed", "decisive"),
    [
        ({}, True),
        ({"t": MIN_T - 0.1}, False),
        ({"share": MIN_DECISIVE_SHARE - 0.01}, False),
        ({"reduction": MIN_DECISIVE_REDUCTION / 2}, False),
    ],
)
def test_decision_against_an_equivalent_model_needs_all_of_it(changed: dict[str, float], decisive: bool) -> None:
    assert is_decisive(improvement(**changed)) is decisive


def test_few_blocks_support_what_changes_nothing_elsewhere() -> None:
    few = improvement(t=2.5, low=0.0, share=0.1)
    assert not is_supported(few)
    assert is_supported(replace(few, t_for_change=MIN_T + 0.1))
    assert not is_supported(replace(few, t_for_change=MIN_T - 0.1))


def test_no_improvement_supports_nothing() -> None:
    nothing = Improvement(0.0, (0.0, 0.0), 0.0, 0.0, 0.0)
    assert not is_supported(nothing)
    assert not is_decisive(nothing)
