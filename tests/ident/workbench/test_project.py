"""A folder is a project: what is done is kept there, and another workbench goes on with it, on the same port."""

import json
import shutil
import signal
import stat
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import httpx
import pytest

from delta_web import local
from ident.diagnosis.document.document import StepEntry
from ident.diagnosis.judge.improvement import Improvement
from ident.workbench.state.history import History
from ident.workbench.state.project import FOLDER, Access, Project
from ident.workbench.state.session import WorkbenchSession, open_session
from ident.workbench.worker import views
from recordings.files import sha256
from tests.chromium import PATIENCE
from tests.ident.workbench.conftest import Browser, NewFolder, Serve
from tests.ident.workbench.test_session import SAMPLES


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with two recordings."""
    for name, sample in (("a.mcap", "fig5a.mcap"), ("b.mcap", "fig5b.mcap")):
        shutil.copy(SAMPLES / sample, tmp_path / name)
    return tmp_path


@pytest.fixture(autouse=True)
def _without_worker(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is computed but where a server runs."""
    if "serve" not in request.fixturenames:
        monkeypatch.setattr("ident.workbench.worker.process.Worker.submit", lambda *arguments: None)


def content(folder: Path) -> dict[str, Any]:
    document: dict[str, Any] = json.loads((folder / FOLDER / "project.json").read_text())
    return document


def steps(*effects: str) -> views.StepsView:
    """Return the base model with one step for each of the `effects`."""
    made = []
    for number in range(len(effects) + 1):
        terms = tuple((name, (1, 2, 3)) for name in ("rod_inertia", *effects[:number]))
        entry = StepEntry(
            added=terms[-1][0], effects=(), train_rms=(0.1, 0.2, 0.3), held_out_rms=(0.1,) * 3, parameters={}
        )
        gain = Improvement(1 / 3, (0.1, 0.5), 9.0, 2.0, 0.1) if number else None
        made.append(views.StepView(f"model {number}", entry, terms, (0.1 + 0.2, 1e-17), gain, ""))
    digests = tuple(sha256(SAMPLES / f"{name}.mcap") for name in ("fig5a", "fig5b"))
    return views.StepsView(
        "a.mcap", "b.mcap", digests, tuple(made), (None, 0.1, 0.1), ("N m",) * 3, ("rad",) * 3, False, True, 25.0,
        "b", None, ("rod_inertia",), views.Findings({"sentence": "Nothing is missing."}, None),
    )  # fmt: skip


def work(folder: Path) -> list[Any]:
    """Do something in `folder`: two branches, the second with an undone model; return what `told` tells."""
    with closing(open_session([folder])) as session:
        selection = session.selection
        history = History.start(steps()).extended(steps("stribeck"))
        selection.history = history.at(0).extended(steps("stribeck", "backlash")).extended(steps("joint_spring"))
        session.jobs.stop()  # the reading
        selection.go(lambda history: history.at(history.undo))
        session.notes = "joint 2 was warm"
        session.display.tab, session.display.dark = "missing", True
        session.display.fields["record-cycles"] = 3
        session.changes.mark("tab")
        return told(session)


def told(session: WorkbenchSession) -> list[Any]:
    history = session.selection.history
    assert history
    return [(entry.made.steps, entry.made.findings, entry.before) for entry in history.entries]


def test_another_workbench_goes_on_with_everything(folder: Path) -> None:
    before = work(folder)
    with closing(open_session([folder])) as session:
        assert (session.recordings.train, session.recordings.validate) == ("a.mcap", "b.mcap")
        assert told(session) == before, "all numbers are the same to the last bit"
        assert session.selection.history
        assert (session.selection.history.current, session.selection.history.end) == (2, 3)
        assert (session.notes, session.display.tab, session.display.dark) == ("joint 2 was warm", "missing", True)
        assert session.display.fields == {"record-cycles": 3}
        session.jobs.stop()
        session.selection.go(lambda history: history.at(history.redo))
        assert session.selection.steps
        assert [name for name, _ in session.selection.steps.added] == ["joint_spring"]
        assert content(folder)["history"]["current"] == 3


def _change(folder: Path) -> None:
    shutil.copy(folder / "b.mcap", folder / "a.mcap")


def _forget_effect(folder: Path) -> None:
    path = folder / FOLDER / "project.json"
    path.write_text(path.read_text().replace('"backlash"', '"my_effect"'))


def _cut(folder: Path) -> None:
    path = folder / FOLDER / "project.json"
    path.write_text(path.read_text()[:300])


def _no_such_branch(folder: Path) -> None:
    path = folder / FOLDER / "project.json"
    document = content(folder)
    document["history"]["end"] = 7
    path.write_text(json.dumps(document))


@pytest.mark.parametrize(
    ("harm", "why"),
    [
        (_change, "a recording has changed since"),
        (lambda folder: (folder / "b.mcap").unlink(), "a file in"),
        (_forget_effect, "this library has no my_effect"),
        (_cut, "project.json cannot be read"),
        (_no_such_branch, "project.json cannot be read"),
    ],
)
def test_models_that_no_longer_fit_are_set_aside(harm: Callable[[Path], None], why: str, folder: Path) -> None:
    work(folder)
    harm(folder)
    kept = (folder / FOLDER / "project.json").read_bytes()
    (folder / FOLDER / "project-before.json").touch()
    with closing(open_session([folder])) as session:
        assert session.selection.history is None
        assert why in session.project.says
        assert (folder / FOLDER / "project-before-2.json").read_bytes() == kept, "those of before stay, too"


def test_recordings_that_are_named_take_the_place_of_others(folder: Path) -> None:
    before = work(folder)
    with closing(open_session([folder / "a.mcap", folder / "b.mcap"])) as session:
        assert told(session) == before
    with closing(open_session([folder / "b.mcap"])) as session:
        assert (session.recordings.train, session.recordings.validate) == ("b.mcap", None)
        assert session.selection.history is None
        assert "they are of other recordings" in session.project.says
        assert session.notes == "joint 2 was warm"


def test_folder_that_cannot_be_written_is_kept_in_memory(folder: Path) -> None:
    (folder / FOLDER).touch()
    with closing(open_session([folder])) as session:
        assert "Kept in memory alone" in session.project.says
        session.choose("b.mcap", None)
        session.project.keep_access(Access(1, "secret"))
        assert session.project.access() is None
    assert (folder / FOLDER).read_bytes() == b""


def test_disk_that_is_full_for_a_while_is_said_for_a_while(folder: Path) -> None:
    with closing(open_session([folder])) as session:
        blocking = folder / FOLDER / "project.json.part"
        blocking.mkdir()
        session.changes.mark("folder")
        assert "Kept in memory alone" in session.project.says
        blocking.rmdir()
        session.changes.mark("folder")
        assert "as you work" in session.project.says


def test_link_is_not_followed(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    (folder / FOLDER).symlink_to(elsewhere)
    with closing(open_session([folder])) as session:
        session.changes.mark("folder")
        assert "Kept in memory alone" in session.project.says
    assert not list(elsewhere.iterdir())


def test_second_workbench_leaves_the_first_its_files(folder: Path) -> None:
    with closing(open_session([folder])) as first:
        first.project.keep_access(Access(1, "secret"))
        with closing(open_session([folder])) as second:
            assert "another workbench" in second.project.says
            assert second.project.access() is None
            second.choose("b.mcap", None)
        first.changes.mark("folder")
        assert content(folder)["train"] == "a.mcap"


@pytest.mark.parametrize("hostile", ["readable", "link", "damaged"])
def test_secret_that_others_may_know_is_not_used_again(hostile: str, tmp_path: Path) -> None:
    project = Project(tmp_path)
    project.open()
    project.keep_access(Access(8123, "secret"))
    path = tmp_path / FOLDER / "access.json"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert project.access() == Access(8123, "secret")
    if hostile == "readable":
        path.chmod(0o644)
    elif hostile == "link":
        path.rename(tmp_path / "access")
        path.symlink_to(tmp_path / "access")
    else:
        path.write_text("{}")
    assert project.access() is None
    project.close()


@pytest.mark.slow
def test_other_port_is_said(folder: Path, serve: Serve) -> None:
    first = serve(folder)
    first.process.send_signal(signal.SIGKILL)
    first.process.wait()
    port = urlsplit(first.address).port
    with local.listen(port):
        second = serve(folder)
    httpx.get(second.address, timeout=PATIENCE).raise_for_status()
    assert second.process.stdout
    lines = [second.process.stdout.readline() for _ in range(2)]
    assert f"was on port {port}" in lines[1]
    assert second.address.partition("?")[2] != first.address.partition("?")[2], "the other may have been told it"


@pytest.mark.slow
def test_tab_goes_on_after_a_kill(hidden: NewFolder, serve: Serve, browser: Browser) -> None:
    first = serve(hidden())
    browser.open(first.address, width=1400)
    browser.click("fit", "tab-missing", "add-stribeck")
    browser.at("step-2").wait_for()
    browser.click("undo", "add-quadratic_friction")
    browser.at("branch-2").wait_for()
    browser.page.evaluate("window.kept = true")
    first.process.kill()
    first.process.wait()
    assert serve(first.folder).address == first.address
    browser.page.wait_for_function("!window.kept")
    browser.at("branch-2").filter(has_text="(current)").wait_for()
    browser.errors.clear()  # that nobody answered
    browser.click("undo")
    browser.at("step-2").wait_for(state="detached")
    browser.click("switch-1")
    browser.at("banner-save").wait_for()  # the analysis is there again
