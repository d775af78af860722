"""Jobs can be paused, resumed and cancelled; cancelling leaves the state unchanged."""

import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from ident.workbench.folder import Folder
from ident.workbench.session import WorkbenchSession
from recordings.errors import BadInput
from tests.ident.commands.test_axes import write

SAMPLES = Path("recordings/samples").resolve()


@pytest.fixture
def session() -> Iterator[WorkbenchSession]:
    """Return a session with a fitted base model."""
    session = WorkbenchSession(Folder.at(SAMPLES))
    session.choose("fig5a.mcap", "fig5b.mcap")
    session.fit()
    wait(lambda: session.residuals is not None and session.job is None)
    yield session
    session.close()


def wait(done: Callable[[], bool], timeout: float = 300.0) -> None:
    end = time.monotonic() + timeout
    while not done():
        assert time.monotonic() < end, "timeout"
        time.sleep(0.02)


def state(session: WorkbenchSession) -> list[str]:
    """Return /proc/PID/stat of the worker from its third field on; see proc(5)."""
    process = session._worker._process
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
    session.diagnose()
    wait(lambda: session.job is not None)
    session.pause()
    wait(lambda: suspended(session))
    before = cpu_time(session)
    assert session.job
    waited = session.job.seconds
    time.sleep(1.0)
    assert cpu_time(session) == before, "it does not compute"
    assert session.job.seconds == waited, "the clock of the job stops too"
    with pytest.raises(BadInput, match="paused"):
        session.show_recording("fig5a.mcap")
    with pytest.raises(BadInput, match="paused"):
        session.fit()
    assert session.diagnosis is None
    session.resume()
    wait(lambda: session.diagnosis is not None)


def test_job_that_ends_while_it_is_being_paused_does_not_block_the_next() -> None:
    session = WorkbenchSession(Folder.at(SAMPLES))
    session.choose("fig5a.mcap", None)
    wait(lambda: session.job is None)
    session.show_recording("fig5b.mcap")
    session.pause()
    session._on_message("idle", None)  # its last message was already sent
    assert session.job is None
    session.recording = None
    session.show_recording("fig5a.mcap")
    wait(lambda: session.recording is not None)
    session.close()


def test_recording_of_another_machine_is_not_accepted_for_validation(tmp_path: Path) -> None:
    shutil.copy(SAMPLES / "fig5a.mcap", tmp_path)
    write(tmp_path / "slide.mcap", 0)
    session = WorkbenchSession(Folder.at(tmp_path))
    session.choose("fig5a.mcap", "slide.mcap")
    wait(lambda: session.recording is not None and session.job is None)
    assert session.train == "fig5a.mcap"
    assert session.validate is None
    assert "axes in slide.mcap" in session.message
    session.close()


@pytest.mark.slow
def test_cancelled_job_leaves_the_state_unchanged(session: WorkbenchSession) -> None:
    ladder = session.ladder
    session.add("torque_offset")
    wait(lambda: session.ladder is not ladder and session.job is None)
    session.undo()
    wait(lambda: session.ladder is ladder or session.job is None)
    for start_job in (session.diagnose, lambda: session.swarm(0), session.redo):
        before = session.branches
        start_job()
        session.pause()
        session.cancel()
        assert session.job is None
        assert session.swarm_progress is None
        assert session.branches is before
    assert session.branches
    assert len(session.branches.current.undone_ladders) == 1
    session.redo()
    wait(lambda: session.job is None)
    assert session.ladder
    assert session.ladder.steps[-1].label == "+ torque_offset"
    assert session.residuals, "a new process continues from there"


@pytest.mark.slow
def test_interrupted_analysis_is_resumed_afterwards(session: WorkbenchSession) -> None:
    session.add("torque_offset")
    wait(lambda: session.candidates is None)
    wait(lambda: bool(session.ladder and len(session.ladder.steps) == 3 and session.job and not session.job.blocking))
    session.swarm(0)
    wait(lambda: session.swarm_result is not None and session.residuals is not None)
    assert session.swarm_result
    assert session.swarm_result.model.effects == ("rod_inertia", "torque_offset")
    assert session.candidates
    assert session.ladder
    assert len(session.ladder.steps) == 3
