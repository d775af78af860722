"""Parts of the page without a browser: what is drawn when, time plots, poses, and descriptions of a time span."""

import asyncio
import io
import sys
import zipfile
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast
from unittest.mock import Mock

import numpy as np
import pytest
from nicegui import Client, ui
from nicegui.testing.user_interaction import UserInteraction
from numpy.typing import NDArray

from ident.diagnosis.judge.improvement import Improvement
from ident.workbench.figure import Figure
from ident.workbench.pages import command, plots
from ident.workbench.pages.missing_effects import improvement_text
from ident.workbench.pages.model import describe_span, explain_gaps, rank_effects, summary
from ident.workbench.pages.page import Page, ZoomablePlot, in_background, quiet
from ident.workbench.pages.robot import PoseSequence, pose_sequence
from ident.workbench.programs.running import run
from ident.workbench.state.cli_equivalent import table2_command
from ident.workbench.topics import Changes
from ident.workbench.worker.views import RecordingView, TorqueSeries
from recordings.rig import Geometry

HOUR = 1_800_000
GREY = "#8a949c"
GEOMETRY, TIME = Geometry(), np.arange(100) / 50


@pytest.fixture
def page() -> Page:
    session = SimpleNamespace(changes=Changes(), display=SimpleNamespace(tab="data"))
    return Page(cast(Any, session), cast(Any, None))


def test_change_during_the_first_drawing_is_not_lost(page: Page) -> None:
    # Another thread brings the cards just after they were looked at.
    draw = Mock(side_effect=lambda page: draw.call_count == 1 and page.session.changes.mark("candidates"))
    page.watch(draw, "candidates")
    page.poll()
    page.poll()
    assert draw.call_count == 2


def test_changes_are_drawn_at_intervals_and_messages_once(page: Page) -> None:
    page.session.changes.mark("message")
    draw, show = Mock(), Mock()
    page.watch(draw, "run", min_interval=60.0)
    page.watch(show, "message", now=False)
    page.session.changes.mark("run")
    page.poll()
    assert (draw.call_count, show.call_count) == (1, 0), "the message was shown before"
    page.session.changes.mark("message")
    page.poll()
    assert (draw.call_count, show.call_count) == (1, 1)


def test_hidden_tab_shows_nothing_of_before_until_it_is_drawn_anew(page: Page) -> None:
    with Client(ui.page("/")):
        page.drawn_tab = page.visible_tab = "model"
        shown = page.draw_on_change(lambda page: quiet(page.visible_tab), "series")
        page.visible_tab = "data"
        page.poll()
        assert shown.default_slot.children, "nothing has changed"
        page.session.changes.mark("series")
        page.poll()
        assert not shown.default_slot.children
        page.show("model")
        assert len(shown.default_slot.children) == 1


@pytest.mark.parametrize("gone", ["nothing", "button", "page"])
def test_program_that_takes_long_can_be_cancelled_and_leaves_no_notice(
    gone: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("ident.workbench.pages.page._PATIENCE", 0.0)
    client = Client(ui.page("/"))
    with client:
        slot = ui.row().default_slot
    sleep = partial(run, tmp_path, (sys.executable, "-c", "import time; time.sleep(60)"), ["import"])

    async def work() -> object:
        with slot:
            return await in_background(sleep)

    async def cancel() -> object:
        result = asyncio.ensure_future(work())
        while not (buttons := {item for item in client.elements.values() if isinstance(item, ui.button)}):
            await asyncio.sleep(0.01)
        UserInteraction(cast(Any, SimpleNamespace(client=client)), buttons, None).trigger("click")
        if gone == "button":
            slot.parent.delete()
        elif gone == "page":
            client.delete()
        return await result

    before = len(client.elements)
    assert asyncio.run(cancel()) is None
    assert len(client.elements) == {"nothing": before, "button": before - 1, "page": 0}[gone]
    said = [data["message"] for _, kind, data in client.outbox.messages if kind == "notify"]
    assert said == ["Cancelled (import)."]


def test_plots_of_a_recording_are_zoomed_together(page: Page) -> None:
    page.session.display = cast(Any, SimpleNamespace(dark=False, spans={}))
    shown: dict[str, list[plots.Span]] = {"a": [], "same": [], "part": [], "b": []}

    def draw(name: str, recording: str, whole: plots.Span) -> ZoomablePlot:
        def figure(span: plots.Span) -> Figure:
            shown[name].append(span)
            return {"data": [], "layout": {"height": 100}}

        return ZoomablePlot(page, lambda: recording, figure, lambda: whole, name)

    with Client(ui.page("/")):
        first = draw("a", "a", (0, 9))
        drawn = [draw("same", "a", (0, 8)), draw("part", "a", (6, 9)), draw("b", "b", (0, 9))]
        for arguments in ({"xaxis2.range[0]": 2, "xaxis2.range[1]": 3}, {"yaxis.autorange": True}):
            first._on_relayout(cast(Any, SimpleNamespace(args=arguments)))
        assert not first.is_whole
        assert shown == {"a": [(0, 9), (2, 3)], "same": [(0, 8), (2, 3)], "part": [(6, 9), (6, 9)], "b": [(0, 9)]}
        drawn[0].plot.delete()
        first._on_relayout(cast(Any, SimpleNamespace(args={"xaxis.autorange": True})))
    assert first.is_whole
    assert (shown["a"][-1], len(shown["same"])) == ((0, 9), 2), "what is gone is not drawn"


def test_command_runs_and_what_it_writes_can_be_downloaded(
    page: Page, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def run_ident(root: Path, *words: str) -> str:
        (root / words[-1]).mkdir()
        (root / words[-1] / "figure.csv").write_text("1")
        return "Table 2"

    monkeypatch.setattr(command, "run_ident", run_ident)
    page.session.folder = cast(Any, SimpleNamespace(root=tmp_path))
    button, client = Mock(), Client(ui.page("/"))
    monkeypatch.setattr(page, "button", button)
    words = table2_command("a.mcap", "b.mcap", "out")

    async def press() -> None:
        with client:
            command.draw_command(page, ui.row(), "Compare", "table2", lambda: (words, ("out",)))
            await button.call_args.args[2]()

    asyncio.run(press())
    shown = [item.content for item in client.elements.values() if isinstance(item, ui.markdown)]
    assert ["Table 2" in shown[0], "ident table2 a.mcap b.mcap --plots out" in shown[1]] == [True, True]
    assert button.call_args.args[0] == "Download out.zip"
    with zipfile.ZipFile(io.BytesIO(command.packed(tmp_path / "out"))) as archive:
        assert archive.read("out/figure.csv") == b"1"


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


def moving(theta: NDArray[np.float32]) -> RecordingView:
    return RecordingView("a", {}, (), (), (), GEOMETRY, TIME, {"position": ("rad", theta)})


def test_limbs_have_the_lengths_of_the_geometry() -> None:
    theta = np.stack([0.3 * np.sin(TIME + phase) - 0.3 for phase in (0, 1, 2)], axis=1).astype(np.float32)
    theta[50] = np.nan
    poses = pose_sequence(moving(theta), GEOMETRY, None)
    rods = poses.platform_joints - poses.elbows
    np.testing.assert_allclose(np.linalg.norm(poses.elbows - poses.shoulders, axis=2), GEOMETRY.L1)
    np.testing.assert_allclose(np.linalg.norm(rods, axis=2), GEOMETRY.L2, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(poses.tangents, axis=1), 1.0)
    np.testing.assert_allclose(np.sum(poses.tangents * poses.shoulders, axis=1), 0.0, atol=1e-12)
    rotation = np.array(PoseSequence.cylinder_rotation(poses.elbows[3, 0], poses.platform_joints[3, 0]))
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(rotation @ [0, GEOMETRY.L2, 0], rods[3, 0], atol=1e-9)
    assert poses.colour(0, 0) == GREY


def test_limbs_with_noise_alone_are_grey() -> None:
    residual = np.full((100, 3), 0.05) * (-1.0, 1.0, 1.0)
    residual[:, 2] = np.nan
    nothing, still = np.zeros((100, 3)), np.full((100, 3), "cruise")
    series = TorqueSeries(
        "a", False, TIME, residual, nothing, nothing, nothing, still, np.ones(100, int), np.isfinite(residual)
    )
    view = moving(np.full((100, 3), -0.3, np.float32))
    poses = pose_sequence(view, GEOMETRY, series, (0.04, 0.001, 0.04))
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


@pytest.mark.parametrize(
    ("share", "interval", "text"),
    [
        (0.334, (0.101, 0.5), "33 % (10 to 50)"),
        (0.997, (0.97, 1.0), "100 % (97 to 100)"),
        (0.9996, (0.9992, 1.0), "over 99 %"),
    ],
)
def test_improvement_in_words(share: float, interval: tuple[float, float], text: str) -> None:
    assert improvement_text(Improvement(share, interval, 9.0, 1.0, 0.0)) == text
