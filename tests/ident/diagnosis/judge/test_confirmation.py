"""The rule when an effect counts as confirmed."""

from dataclasses import replace

import pytest

from ident.diagnosis.judge.confirmation import (
    MIN_DECISIVE_REDUCTION,
    MIN_DECISIVE_SHARE,
    MIN_LOWER_BOUND,
    MIN_T,
    is_decisive,
    is_structure,
    is_supported,
)
from ident.diagnosis.judge.improvement import Improvement


def test_structure_needs_no_noise_floor() -> None:
    """Where one block outweighs the others, the ratio in most of them tells structure."""
    assert is_structure(Improvement(0.9, (-1.0, 1.0), 2.0, 100.0, 1.0, t_of_ratio=MIN_T + 0.1))
    assert not is_structure(Improvement(0.9, (-1.0, 1.0), 2.0, 100.0, 1.0, t_of_ratio=MIN_T - 0.1))
    assert is_structure(Improvement(0.9, (0.8, 1.0), 10.0, 100.0, 1.0))


def improvement(
    t: float = 10.0, low: float = 0.5, share: float = 0.8, reduction: float = 1.0, remaining: float = 0.1
) -> Improvement:
    return Improvement(share, (low, 1.0), t, reduction, remaining)


@pytest.mark.parametrize(
    ("t", "low", "supported"),
    [
        (MIN_T + 0.1, -0.5, True),  # a small one in most blocks
        (1.0, MIN_LOWER_BOUND + 0.01, True),  # a large one in a few
        (MIN_T - 0.1, MIN_LOWER_BOUND - 0.01, False),
        (-10.0, -1.0, False),
    ],
)
def test_support_needs_many_blocks_or_a_large_share(t: float, low: float, supported: bool) -> None:
    assert is_supported(improvement(t=t, low=low)) is supported


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
