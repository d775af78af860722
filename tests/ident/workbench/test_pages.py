"""Parts of the page without a browser: what is drawn when, what is pressed twice, and zoomed plots."""

import asyncio
import io
import sys
import zipfile
from collections.abc import Iterator
from contextlib import closing
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast
from unittest.mock import Mock

import pytest
from nicegui import Client, ui
from nicegui.testing.user_interaction import UserInteraction

from ident.diagnosis.judge.improvement import Improvement
from ident.output.figures.time_plots import Span
from ident.workbench.figure import Figure
from ident.workbench.folder import Folder
from ident.workbench.pages import command, record
from ident.workbench.pages.missing_effects import improvement_text
from ident.workbench.pages.page import Page, ZoomablePlot, in_background
from ident.workbench.programs.running import run
from ident.workbench.state.cli_equivalent import table2_command
from ident.workbench.state.session import WorkbenchSession
from ident.workbench.topics import Changes
from recordings.errors import BadInput


@pytest.fixture
def page() -> Iterator[Page]:
    session = SimpleNamespace(changes=Changes(), display=SimpleNamespace(tab="data", printed={}))
    with Client(ui.page("/")):
        yield Page(cast(Any, session), ui.element())


def test_change_during_the_first_drawing_is_not_lost(page: Page) -> None:
    # Another thread brings the cards just after they were looked at.
    draw = Mock(side_effect=lambda page: draw.call_count == 1 and page.session.changes.mark("candidates"))
    page.watch(draw, "candidates")
    page.poll()
    page.poll()
    assert draw.call_count == 2


def test_what_is_gone_is_not_drawn_and_messages_are_shown_once(page: Page) -> None:
    page.session.changes.mark("message")
    draw, show = Mock(), Mock()
    with ui.row() as row:
        page.watch(draw, "run")
    page.watch(show, "message", now=False)
    page.session.changes.mark("run")
    page.poll()
    assert (draw.call_count, show.call_count) == (2, 0), "the message was shown before"
    row.delete()
    page.session.changes.mark("run", "message")
    page.poll()
    assert (draw.call_count, show.call_count) == (2, 1)


def test_second_press_does_nothing_while_the_first_goes_on(page: Page, monkeypatch: pytest.MonkeyPatch) -> None:
    said = Mock()
    monkeypatch.setattr("ident.workbench.pages.page.notify", said)
    calls, busy = [], []

    async def action() -> None:
        calls.append(len(calls))
        await asyncio.sleep(0)
        raise BadInput("no such file")

    press = page.handler(action, show_busy=busy.append)
    row = ui.row()

    async def twice() -> None:
        with row:
            first = press()
            assert press() is None
        row.delete()  # as when another tab is shown
        await first
        assert said.call_args.args == ("no such file", "warning"), "no traceback in the terminal"
        await press()

    asyncio.run(twice())
    assert (calls, busy) == ([0, 1], [True, False, True, False])


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


@pytest.mark.parametrize(("rig", "said"), [("bench.toml", "Real drives move"), ("simulated", "no real robot moves")])
def test_form_of_a_recording_that_is_shown_again_says_which_drives_move(rig: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "bench.toml").touch()
    with closing(WorkbenchSession(Folder.at(tmp_path))) as session, Client(ui.page("/")) as client:
        session.display.fields["record-rig"] = rig
        record.draw(Page(session, ui.element()))
        (safety,) = (item for item in client.elements.values() if item.props.get("data-test") == "safety")
        assert said in cast(ui.label, safety).text


def test_form_changes_no_number_and_says_what_a_killed_workbench_left(tmp_path: Path) -> None:
    with closing(WorkbenchSession(Folder.at(tmp_path))) as session, Client(ui.page("/")) as client:
        session.interrupted = "The workbench ended while a.mcap was running"
        session.display.fields |= {"record-cycles": 0, "record-hidden": "-3"}
        start = session.recorder.start = Mock()  # type: ignore[method-assign]
        record.draw(Page(session, ui.element()))
        items: dict[str, Any] = {item.props.get("data-test"): item for item in client.elements.values()}
        assert items["run-state"].text == session.interrupted
        items["record-cycles"].sanitize()  # as it does when it is left
        items["record-out"].value = ""
        UserInteraction(cast(Any, SimpleNamespace(client=client)), {items["record"]}, None).click()
        options = {"--traj": "fig5a", "--cycles": "0", "--hidden": "-3"}
        start.assert_called_once_with(options, tmp_path / "fig5a.mcap")


def test_plots_of_a_recording_are_zoomed_together(page: Page) -> None:
    page.session.display = cast(Any, SimpleNamespace(dark=False, spans={}))
    shown: dict[str, list[Span]] = {"a": [], "same": [], "part": [], "b": []}

    def draw(name: str, recording: str, whole: Span) -> ZoomablePlot:
        def figure(span: Span) -> Figure:
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
    def printed_by(root: Path, *words: str) -> str:
        (root / words[-1]).mkdir()
        (root / words[-1] / "figure.csv").write_text("1")
        return "Table 2"

    monkeypatch.setattr(command, "printed_by", printed_by)
    page.session.folder = cast(Any, SimpleNamespace(root=tmp_path))
    button = Mock()
    monkeypatch.setattr(page, "button", button)
    words = table2_command("a.mcap", "b.mcap", "out")

    row = ui.row()

    async def press() -> None:
        with row:
            await button.call_args.args[2]()

    command.draw_command(page, row, "Compare", "table2", lambda: (words, ("out",)))
    asyncio.run(press())
    page.poll()
    shown = [item.content for item in ui.context.client.elements.values() if isinstance(item, ui.markdown)]
    assert ["Table 2" in shown[0], "ident table2 a.mcap b.mcap --plots out" in shown[1]] == [True, True]
    assert button.call_args.args[0] == "Download out.zip"
    with zipfile.ZipFile(io.BytesIO(command.packed(tmp_path / "out"))) as archive:
        assert archive.read("out/figure.csv") == b"1"


@pytest.mark.parametrize(
    ("share", "interval", "text"),
    [
        (0.334, (0.101, 0.5), "33 % (10 to 50)"),
        (0.997, (0.97, 1.0), "100 % (97 to 100)"),
        (0.994, (0.991, 0.9949), "99 %"),
        (0.99, (-1.0, 1.0), "99 %, or none"),
        (0.9996, (0.9992, 1.0), "over 99 %"),
    ],
)
def test_improvement_in_words(share: float, interval: tuple[float, float], text: str) -> None:
    assert improvement_text(Improvement(share, interval, 9.0, 1.0, 0.0)) == text
