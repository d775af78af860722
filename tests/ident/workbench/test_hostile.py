"""Hostile recordings: their contents are shown as plain text, or they are refused with a message."""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from ident.workbench.folder import SUFFIX, Folder
from ident.workbench.session import WorkbenchSession
from ident.workbench.worker import Message, TaskEnd, Worker
from recordings.recording import Recording
from tests.ident.workbench.conftest import Browser, Serve
from web.security import MAX_BODY_BYTES

IMAGE = "<img src=x onerror=window.hacked=1>"
SCRIPT = "<script>window.hacked=1</script>"
NAME = "<img src=x onerror=window.hacked=1>.mcap"


@pytest.fixture
def folder(tmp_path: Path, make: Callable[..., Recording], write: Callable[[Recording], Path]) -> Path:
    recording = make(path=tmp_path / "evil.mcap", rate=250.0)
    rig = recording.rig.model_copy(update={"name": IMAGE})
    run = recording.run.model_copy(update={"trajectory": SCRIPT, "software": IMAGE})
    write(replace(recording, rig=rig, run=run))
    (tmp_path / NAME).write_bytes((tmp_path / "evil.mcap").read_bytes())
    with (tmp_path / "huge.mcap").open("wb") as file:
        file.truncate(2**30)
    return tmp_path


@pytest.mark.slow
def test_names_and_metadata_are_shown_as_text(folder: Path, serve: Serve, browser: Browser) -> None:
    browser.open(serve(folder).address)
    page, names = browser.page, Folder.at(folder).names(SUFFIX)
    page.get_by_text(NAME).wait_for()
    browser.click(f"train-{names.index('evil.mcap')}")
    assert browser.text("quality-rig") == IMAGE
    assert SCRIPT in browser.text("quality-motion")
    browser.click(f"train-{names.index(NAME)}")
    page.get_by_text("a plain file name").wait_for()
    browser.click(f"train-{names.index('huge.mcap')}")
    page.get_by_text("is not an MCAP file").wait_for()
    browser.screenshot("hostile")
    assert page.evaluate("window.hacked") is None
    assert not page.locator("img[src=x]").count()


def test_worker_refuses_a_huge_file(folder: Path) -> None:
    """It neither exhausts the memory nor ends the page."""
    messages: list[Message] = []
    worker = Worker(messages.append, ())
    worker.submit("view_recording", folder / "huge.mcap")
    for _ in range(600):
        if any(isinstance(message, TaskEnd) for message in messages):
            break
        time.sleep(0.1)
    assert isinstance(messages[-1], TaskEnd)
    assert "is not an MCAP file" in str(messages[-1].error)
    assert not worker.needs_start
    worker.cancel()
    assert worker.needs_start


def test_session_refuses_names_outside_the_folder(folder: Path) -> None:
    session = WorkbenchSession(Folder.at(folder))
    for name in ("../evil.mcap", "/etc/passwd", NAME, "missing.mcap"):
        with pytest.raises(ValueError, match="expected"):
            session.choose(name, None)
        with pytest.raises(ValueError, match="expected"):
            session.recordings.show(name)
    with pytest.raises(ValueError, match="another recording"):
        session.choose("evil.mcap", "evil.mcap")
    with pytest.raises(ValueError, match="none chosen"):
        session.selection.fit()
    assert session.recordings.train is None
    assert MAX_BODY_BYTES < 2**30
    session.close()
