"""Jobs can be cancelled, which leaves the state unchanged."""

import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest

from ident.workbench.folder import Folder
from ident.workbench.state.session import WorkbenchSession
from tests.ident.commands.test_axes import write
from tests.patience import patient

SAMPLES = Path("recordings/samples").resolve()


@pytest.fixture
def session() -> Iterator[WorkbenchSession]:
    """Return a session on the samples."""
    with closing(WorkbenchSession(Folder.at(SAMPLES))) as session:
        yield session


@pytest.fixture
def fitted(session: WorkbenchSession) -> WorkbenchSession:
    """Return a session with a fitted base model."""
    session.choose("fig5a.mcap", "fig5b.mcap")
    session.selection.fit()
    wait(lambda: session.selection.analysis.residuals is not None and session.jobs.current is None)
    return session


def wait(done: Callable[[], bool], timeout: float = 300.0) -> None:
    end = time.monotonic() + patient(timeout)
    while not done():
        assert time.monotonic() < end, "timeout"
        time.sleep(0.02)


ENDLESS = """
import pathlib, time
pathlib.Path("busy").touch()
time.sleep(600)
"""
KILLED = """
import os, pathlib, signal, time
from ident.workbench.worker.process import Worker
worker = Worker(print, [pathlib.Path("endless.py")])
worker.prepare()
while not pathlib.Path("busy").exists():
    time.sleep(0.02)
os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.slow
def test_worker_ends_with_a_server_that_is_killed(tmp_path: Path) -> None:
    (tmp_path / "endless.py").write_text(ENDLESS)
    command = [sys.executable, "-c", KILLED]  # the worker holds the standard output open
    subprocess.run(command, cwd=tmp_path, stdout=subprocess.PIPE, check=False, timeout=patient(300))


@pytest.mark.slow
def test_cancelled_job_leaves_the_state_unchanged(fitted: WorkbenchSession) -> None:
    jobs, selection = fitted.jobs, fitted.selection
    base = selection.steps
    selection.extend("add", "torque_offset")
    wait(lambda: selection.steps is not base and jobs.current is None)
    before = selection.history
    selection.extend("diagnose")
    jobs.cancel()
    assert jobs.current is None
    assert selection.history is before
    selection.extend("remove", 0)
    wait(lambda: jobs.current is None)
    assert selection.steps
    assert selection.steps.steps[-1].label == "− rod_inertia", "a new process continues from there"


@pytest.mark.slow
def test_new_choice_of_recordings_discards_the_results(tmp_path: Path) -> None:
    """A recording of another machine is not accepted for validation."""
    for name in ("fig5a.mcap", "fig5b.mcap"):
        shutil.copy(SAMPLES / name, tmp_path)
    write(tmp_path / "slide.mcap", 0)
    session = WorkbenchSession(Folder.at(tmp_path))
    session.choose("fig5a.mcap", None)
    session.selection.fit()
    wait(lambda: session.selection.steps is not None)
    session.choose("fig5b.mcap", "slide.mcap")
    assert session.selection.history is None
    wait(lambda: session.recordings.shown is not None and session.jobs.current is None)
    assert session.recordings.shown
    assert session.recordings.shown.name == session.recordings.train == "fig5b.mcap"
    assert session.recordings.validate is None
    assert "axes in slide.mcap" in session.jobs.message
    assert session.selection.steps is None, "views of the discarded models never arrive"
    session.close()


def test_all_tasks_end_with_the_worker(session: WorkbenchSession) -> None:
    jobs, recordings = session.jobs, session.recordings
    for name in ("fig5a.mcap", "fig5b.mcap"):
        recordings.show(name)
    jobs.worker._process.kill()
    wait(lambda: jobs.current is None)
    assert "ended unexpectedly" in jobs.message
    recordings.show("fig5a.mcap")
    wait(lambda: recordings.shown is not None)


def test_terminal_goes_on_where_the_page_was_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    for name in ("a.mcap", "b.mcap"):
        (tmp_path / "runs" / name).touch()
    session = WorkbenchSession(Folder.at(Path("runs")))
    assert session.next_command()[:2] == ["daq", "record"]
    session.recordings.train = "a.mcap"
    for validate, saved, command in (
        (None, None, "ident diagnose runs/a.mcap"),
        ("b.mcap", None, "ident diagnose runs/a.mcap --validate runs/b.mcap"),
        ("b.mcap", "a.model.json", "ident compare runs/a.model.json runs/b.mcap"),
        (None, "a.model.json", "ident compare runs/a.model.json runs/a.mcap"),
    ):
        session.recordings.validate = validate
        session.saved.last = saved
        assert " ".join(session.next_command()) == command
