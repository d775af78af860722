"""Jobs can be paused, resumed and cancelled; cancelling leaves the state unchanged."""

import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from ident.workbench.folder import Folder
from ident.workbench.state.model_export import ModelExport
from ident.workbench.state.session import WorkbenchSession
from ident.workbench.worker.process import TaskEnd
from recordings.errors import BadInput
from tests.ident.commands.test_axes import write

SAMPLES = Path("recordings/samples").resolve()


@pytest.fixture
def session() -> Iterator[WorkbenchSession]:
    """Return a session with a fitted base model."""
    session = WorkbenchSession(Folder.at(SAMPLES))
    session.choose("fig5a.mcap", "fig5b.mcap")
    session.selection.fit()
    wait(lambda: session.selection.analysis.residuals is not None and session.jobs.current is None)
    yield session
    session.close()


def wait(done: Callable[[], bool], timeout: float = 300.0) -> None:
    end = time.monotonic() + timeout
    while not done():
        assert time.monotonic() < end, "timeout"
        time.sleep(0.02)


def state(session: WorkbenchSession) -> list[str]:
    """Return /proc/PID/stat of the worker from its third field on; see proc(5)."""
    process = session.jobs.worker._process
    assert process is not None
    return Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()


def suspended(session: WorkbenchSession) -> bool:
    """Return whether the worker is suspended."""
    return state(session)[0] == "T"


def cpu_time(session: WorkbenchSession) -> float:
    """Return the processor time of the worker so far, in ticks."""
    return sum(map(float, state(session)[11:13]))


@pytest.mark.slow
def test_paused_job_uses_no_processor_time_and_resumes(session: WorkbenchSession) -> None:
    jobs, selection = session.jobs, session.selection
    selection.extend("diagnose")
    wait(lambda: jobs.current is not None)
    jobs.pause()
    wait(lambda: suspended(session))
    before = cpu_time(session)
    assert jobs.current
    waited = jobs.current.seconds
    time.sleep(1.0)
    assert cpu_time(session) == before, "it does not compute"
    assert jobs.current.seconds == waited, "the clock of the job stops too"
    with pytest.raises(BadInput, match="paused"):
        session.recordings.show("fig5a.mcap")
    with pytest.raises(BadInput, match="paused"):
        selection.fit()
    assert selection.diagnosis is None
    jobs.resume()
    wait(lambda: selection.diagnosis is not None)


def test_job_that_ends_while_it_is_being_paused_does_not_block_the_next() -> None:
    session = WorkbenchSession(Folder.at(SAMPLES))
    jobs = session.jobs
    with jobs.worker.lock:  # no other message arrives meanwhile
        session.choose("fig5a.mcap", None)
        jobs.pause()
        wait(lambda: suspended(session))
        jobs.receive(TaskEnd())  # its last message was already sent
        assert jobs.current is None
        wait(lambda: not suspended(session))
        session.close()


@pytest.mark.slow
def test_cancelled_job_leaves_the_state_unchanged(session: WorkbenchSession) -> None:
    jobs, selection, swarm = session.jobs, session.selection, session.swarm
    step_list = selection.step_list
    selection.extend("add", "torque_offset")
    wait(lambda: selection.step_list is not step_list and jobs.current is None)
    for start_job in (lambda: selection.extend("diagnose"), lambda: swarm.start(0, selection.step_list)):
        before = selection.branches
        start_job()
        jobs.pause()
        jobs.cancel()
        assert jobs.current is None
        assert swarm.progress is None
        assert selection.branches is before
    selection.extend("remove", 0)
    wait(lambda: jobs.current is None)
    assert selection.step_list
    assert selection.step_list.steps[-1].label == "− rod_inertia", "a new process continues from there"


def test_new_choice_of_recordings_discards_the_results(tmp_path: Path) -> None:
    """A recording of another machine is not accepted for validation."""
    for name in ("fig5a.mcap", "fig5b.mcap"):
        shutil.copy(SAMPLES / name, tmp_path)
    write(tmp_path / "slide.mcap", 0)
    session = WorkbenchSession(Folder.at(tmp_path))
    session.choose("fig5a.mcap", None)
    session.selection.fit()
    wait(lambda: session.selection.step_list is not None)
    session.choose("fig5b.mcap", "slide.mcap")
    assert session.selection.branches is None
    wait(lambda: session.recordings.shown is not None and session.jobs.current is None)
    assert session.recordings.shown
    assert session.recordings.shown.name == session.recordings.train == "fig5b.mcap"
    assert session.recordings.validate is None
    assert "axes in slide.mcap" in session.jobs.message
    assert session.selection.step_list is None, "views of the discarded step_list never arrive"
    session.close()


def test_all_tasks_end_with_the_worker() -> None:
    session = WorkbenchSession(Folder.at(SAMPLES))
    jobs, recordings = session.jobs, session.recordings
    for name in ("fig5a.mcap", "fig5b.mcap"):
        recordings.show(name)
    process = jobs.worker._process
    assert process is not None
    process.kill()
    wait(lambda: jobs.current is None)
    assert "ended unexpectedly" in jobs.message
    recordings.show("fig5a.mcap")
    wait(lambda: recordings.shown is not None)
    session.close()


def test_terminal_goes_on_where_the_page_was_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    for name in ("a.mcap", "b.mcap"):
        (tmp_path / "runs" / name).touch()
    session = WorkbenchSession(Folder.at(Path("runs")))
    assert session.next_command()[:2] == ["daq", "record"]
    session.recordings.train = "a.mcap"
    assert session.next_command() == ["ident", "diagnose", "runs/a.mcap"]
    session.recordings.validate = "b.mcap"
    assert session.next_command() == ["ident", "diagnose", "runs/a.mcap", "--validate", "runs/b.mcap"]
    monkeypatch.setattr(ModelExport, "last_saved", "a.model.json")
    assert session.next_command() == ["ident", "compare", "runs/a.model.json", "runs/b.mcap"]
    session.recordings.validate = None
    assert session.next_command() == ["ident", "compare", "runs/a.model.json", "runs/a.mcap"]
