"""What is said about a span of time that was selected."""

from dataclasses import replace

import numpy as np
import pytest

from ident.residuals.time_span import TorqueSeries, describe_span, explain_gaps, rank_effects, summary


@pytest.fixture
def slow_then_fast() -> TorqueSeries:
    """One joint that is slow and badly explained for a second, then fast."""
    time = np.arange(400) / 100
    return TorqueSeries(
        name="made",
        held_out=False,
        time=time,
        measured=np.where(time < 1, 0.5, 0.1)[:, None] * np.cos(40 * time)[:, None],
        computed=np.zeros((400, 1)),
        velocity=np.where(time < 1, 0.1, 1.0)[:, None],
        position=time[:, None],
        phase=np.where(time < 1, "reversal", "cruise")[:, None],
        cycle=np.where(time < 2, 1, 2),
        scored=np.ones((400, 1), bool),
    )


def test_description_of_a_span(slow_then_fast: TorqueSeries) -> None:
    text = " ".join(describe_span(slow_then_fast, 0, 0.0, 0.99))
    assert "5.0 times the residual elsewhere" in text
    assert "Speed 0.1 rad/s median, slower than usual" in text
    assert "reversal 100 % (usually 25 %)" in text
    assert "Cycle 1." in text
    for end in (0.01, 9.0):
        assert "too short, or covers everything" in describe_span(slow_then_fast, 0, 0.0, end)[0]


def test_ranking_of_the_effects_that_explain_a_span(slow_then_fast: TorqueSeries) -> None:
    residual = slow_then_fast.residual.astype(np.float32)
    contributions = {"half": residual / 2, "all": residual, "worse": -residual, "late": np.roll(residual, 200)}
    shares = rank_effects(slow_then_fast, contributions, 0, 0.0, 0.99)
    assert [*shares] == ["all", "half", "late", "worse"]
    assert [shares[name] for name in ("all", "half", "worse")] == pytest.approx([1.0, 0.75, -3.0])
    assert "would explain" in summary(shares)
    none = rank_effects(slow_then_fast, {"nothing": 0 * residual, "worse": -residual}, 0, 0.0, 0.99)
    assert "nothing explains most, 0 % of its mean square" in summary(none)
    assert "too short" in summary(rank_effects(slow_then_fast, contributions, 0, 0.0, 0.01))


def test_gaps_of_the_residual_are_explained(slow_then_fast: TorqueSeries) -> None:
    assert explain_gaps(slow_then_fast, 0) == ""
    arrays = {name: getattr(slow_then_fast, name).copy() for name in ("scored", "measured", "cycle")}
    arrays["scored"][:40], arrays["cycle"][:40], arrays["scored"][200:220] = False, 0, False
    arrays["measured"][100:120] = np.nan
    text = explain_gaps(replace(slow_then_fast, **arrays), 0)
    assert "10% outside of the repeated motion; 5% lost" in text
    assert "5% at standstill" in text
