"""Long work can be paused, goes on where it stood, and leaves nothing behind when it is cancelled."""

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
    """With a fitted base model."""
    made = WorkbenchSession(Folder.at(SAMPLES))
    made.choose("fig5a.mcap", "fig5b.mcap")
    made.fit()
    wait(lambda: made.residuals is not None and made.job is None)
    yield made
    made.close()


def wait(done: Callable[[], bool], patience: float = 120.0) -> None:
    end = time.monotonic() + patience
    while not done():
        assert time.monotonic() < end, "it takes too long"
        time.sleep(0.02)


def state(session: WorkbenchSession) -> list[str]:
    """What the kernel says of the working process, from its third figure on; see proc(5)."""
    process = session._worker._process
    assert process is not None
    return Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()


def stopped(session: WorkbenchSession) -> bool:
    """Whether the working process stands still."""
    return state(session)[0] == "T"


def used(session: WorkbenchSession) -> float:
    """Processor time of the working process so far, in ticks."""
    return sum(map(float, state(session)[11:13]))


@pytest.mark.slow
def test_paused_work_stands_still_and_goes_on(session: WorkbenchSession) -> None:
    session.diagnose()
    wait(lambda: session.job is not None)
    session.pause()
    wait(lambda: stopped(session))
    before = used(session)
    assert session.job
    waited = session.job.seconds
    time.sleep(1.0)
    assert used(session) == before, "it does not compute"
    assert session.job.seconds == waited, "nor does it count"
    with pytest.raises(BadInput, match="paused"):
        session.show_recording("fig5a.mcap")
    with pytest.raises(BadInput, match="paused"):
        session.fit()
    assert session.diagnosis is None
    session.resume()
    wait(lambda: session.diagnosis is not None)


def test_work_that_ends_just_when_it_is_paused_is_followed_by_other_work() -> None:
    session = WorkbenchSession(Folder.at(SAMPLES))
    session.choose("fig5a.mcap", None)
    wait(lambda: session.job is None)
    session.show_recording("fig5b.mcap")
    session.pause()
    session._on_message("idle", None)  # its last word was on its way
    assert session.job is None
    session.recording = None
    session.show_recording("fig5a.mcap")
    wait(lambda: session.recording is not None)
    session.close()


def test_a_recording_of_another_machine_is_not_taken_to_check_on(tmp_path: Path) -> None:
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
def test_cancelled_work_leaves_all_as_it_was(session: WorkbenchSession) -> None:
    ladder = session.ladder
    session.add("torque_offset")
    wait(lambda: session.ladder is not ladder and session.job is None)
    session.undo()
    wait(lambda: session.ladder is ladder or session.job is None)
    for begin in (session.diagnose, lambda: session.swarm(0), session.redo):
        before = session.branches
        begin()
        session.pause()
        session.cancel()
        assert session.job is None
        assert session.swarm_progress is None
        assert session.branches is before
    assert session.branches
    assert len(session.branches.current.undone) == 1
    session.redo()
    wait(lambda: session.job is None)
    assert session.ladder
    assert session.ladder.steps[-1].label == "+ torque_offset"
    assert session.residuals, "another process went on from there"


@pytest.mark.slow
def test_what_was_left_out_for_something_else_is_looked_at_afterwards(session: WorkbenchSession) -> None:
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
