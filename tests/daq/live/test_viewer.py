"""A viewer cannot disturb the run, neither by reading slowly nor by exiting."""

import json
from contextlib import suppress
from pathlib import Path

import pytest

from daq.live import viewer
from daq.live.viewer import Viewer
from tests.patience import patient

READS = """
import json, sys, pathlib
first = json.loads(sys.stdin.readline())
pathlib.Path(first["into"]).write_text(sys.stdin.read())
"""
STUCK = "import time\ntime.sleep(60)"
DEAD = ""

LINE = "x" * 10_000


@pytest.fixture
def viewer_class(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> "type[Viewer]":
    """`Viewer` with test modules on its path and a short timeout."""
    for name, text in (("reads", READS), ("stuck", STUCK), ("dead", DEAD)):
        (tmp_path / f"{name}.py").write_text(text)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setattr(viewer, "END_TIMEOUT", 0.1)
    return Viewer


@pytest.mark.parametrize("error", [None, "joint 2: following error"])
def test_viewer_receives_all_lines_in_order_and_the_end_last(
    viewer_class: "type[Viewer]", tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: str | None
) -> None:
    monkeypatch.setattr(viewer, "END_TIMEOUT", 120.0)
    sent = [f"{number} {LINE}" for number in range(50)]
    with suppress(RuntimeError), viewer_class("reads", {"into": str(tmp_path / "lines")}) as closing_viewer:
        for line in sent:
            closing_viewer.send(line)
        if error:
            raise RuntimeError(error)
    assert (tmp_path / "lines").read_text().splitlines() == [*sent, json.dumps({"ended": error})]


def test_viewer_that_does_not_read_gets_a_bounded_backlog_and_is_killed(
    viewer_class: "type[Viewer]", monkeypatch: pytest.MonkeyPatch
) -> None:
    """A blocking write would hang here for a minute."""
    monkeypatch.setattr(viewer, "_KILL_DELAY", 0.1)
    with viewer_class("stuck", {}) as closing_viewer:
        for _ in range(1000):
            closing_viewer.send(LINE)
        assert len(closing_viewer._unsent) < 5_000_000
    assert closing_viewer._process.returncode == -9


def test_lines_for_an_exited_viewer_are_dropped(viewer_class: "type[Viewer]") -> None:
    with viewer_class("dead", {}) as viewer:
        viewer._process.wait(patient(120))
        for _ in range(1000):
            viewer.send(LINE)
        assert not viewer._unsent
    assert viewer._process.returncode == 0


def test_modules_in_the_working_folder_are_not_executed(
    viewer_class: "type[Viewer]", tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A json.py in the working folder must not be imported by the viewer."""
    (tmp_path / "work").mkdir()
    (tmp_path / "work" / "json.py").write_text("raise SystemExit(7)")
    monkeypatch.chdir(tmp_path / "work")
    monkeypatch.setattr(viewer, "END_TIMEOUT", 120.0)
    with viewer_class("reads", {"into": str(tmp_path / "lines")}) as closing_viewer:
        pass
    assert closing_viewer._process.returncode == 0
