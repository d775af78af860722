"""Parts of the page without a browser: what is drawn when, time plots, poses, and descriptions of a time span."""

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from ident.workbench.pages import plots
from ident.workbench.pages.page import Page
from ident.workbench.pages.pose import PoseSequence, pose_sequence
from ident.workbench.pages.time_span import describe_span, explain_gaps, rank_effects, summary
from ident.workbench.topics import Changes
from ident.workbench.worker.views import RecordingView, TorqueSeries
from recordings.rig import Geometry

HOUR = 1_800_000
GREY = "#8a949c"


@pytest.fixture
def page() -> Page:
    session = SimpleNamespace(changes=Changes(), display=SimpleNamespace(tab="data"))
    return Page(cast(Any, session), cast(Any, None))


def counter() -> tuple[list[int], Callable[[Page], None]]:
    calls: list[int] = []
    return calls, lambda page: calls.append(1)


def test_change_during_the_first_drawing_is_not_lost(page: Page) -> None:
    seen = []
    state = {"cards": 0}

    def draw(page: Page) -> None:
        seen.append(state["cards"])
        if len(seen) == 1:  # another thread brings the cards just after they were looked at
            state["cards"] = 5
            page.session.changes.mark("candidates")

    page.watch(draw, "candidates")
    page.poll()
    page.poll()
    assert seen == [0, 5]


def test_changes_are_drawn_at_intervals_and_messages_once(page: Page) -> None:
    page.session.changes.mark("message")
    (drawn, draw), (shown, show) = counter(), counter()
    page.watch(draw, "run", min_interval=60.0)
    page.watch(show, "message", now=False)
    page.session.changes.mark("run")
    page.poll()
    assert (len(drawn), len(shown)) == (1, 0), "the message was shown before"
    page.session.changes.mark("message")
    page.poll()
    assert (len(drawn), len(shown)) == (1, 1)


def test_an_hour_is_decimated_without_losing_peaks() -> None:
    time, y = np.arange(HOUR) / 500, np.zeros(HOUR, np.float32)
    y[1_234_567], y[777_777] = 5.0, np.nan
    xs, ys = plots.visible_points(time, y, (0.0, 3600.0))
    assert len(xs) < 4000
    assert np.nanmax(ys) == 5.0
    assert np.isnan(ys).any(), "gaps are kept"
    xs, ys = plots.visible_points(time, y, (2469.0, 2469.2))
    assert len(xs) >= 100
    assert np.nanmax(ys) == 5.0
    assert xs[0] < 2469.0 < 2469.2 < xs[-1], "the line continues to both edges"


def test_limbs_have_the_lengths_of_the_geometry() -> None:
    geometry, time = Geometry(), np.arange(100) / 50
    theta = np.stack([0.3 * np.sin(time + phase) - 0.3 for phase in (0, 1, 2)], axis=1).astype(np.float32)
    theta[50] = np.nan
    poses = pose_sequence(
        RecordingView("a", {}, (), (), (), geometry, time, {"position": ("rad", theta)}), geometry, None
    )
    rods = poses.platform_joints - poses.elbows
    np.testing.assert_allclose(np.linalg.norm(poses.elbows - poses.shoulders, axis=2), geometry.L1)
    np.testing.assert_allclose(np.linalg.norm(rods, axis=2), geometry.L2, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(poses.tangents, axis=1), 1.0)
    np.testing.assert_allclose(np.sum(poses.tangents * poses.shoulders, axis=1), 0.0, atol=1e-12)
    rotation = np.array(PoseSequence.cylinder_rotation(poses.elbows[3, 0], poses.platform_joints[3, 0]))
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(rotation @ [0, geometry.L2, 0], rods[3, 0], atol=1e-9)
    assert poses.colour(0, 0) == GREY


def test_limbs_with_noise_alone_are_grey() -> None:
    geometry, time = Geometry(), np.arange(100) / 50
    view = RecordingView(
        "a", {}, (), (), (), geometry, time, {"position": ("rad", np.full((100, 3), -0.3, np.float32))}
    )
    residual = np.full((100, 3), 0.05) * (-1.0, 1.0, 1.0)
    residual[:, 2] = np.nan
    nothing, still = np.zeros((100, 3)), np.full((100, 3), "cruise")
    series = TorqueSeries(
        "a", False, time, residual, nothing, nothing, nothing, still, np.ones(100, int), np.isfinite(residual)
    )
    poses = pose_sequence(view, geometry, series, (0.04, 0.001, 0.04))
    np.testing.assert_array_equal(poses.residual, residual[: len(poses.time)])
    assert poses.colour(0, 0) == GREY == poses.colour(0, 2), "noise alone, and a row that is not scored"
    assert poses.colour(0, 1) != GREY


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
