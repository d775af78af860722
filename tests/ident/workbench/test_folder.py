"""The page has access only to files of the chosen folder, and refuses or shows as text what is hostile in them."""

import shutil
from pathlib import Path

import pytest

from delta_web.local import LINK_PREFIX
from ident.workbench.folder import SUFFIX, Folder
from ident.workbench.state.session import WorkbenchSession, open_session
from recordings.errors import BadInput

SAMPLES = Path("recordings/samples").resolve()
FOREIGN = SAMPLES / "foreign"


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    root = tmp_path / "runs"
    (root / "inner").mkdir(parents=True)
    for name in ("runs/a.mcap", "runs/inner/b.mcap", "secret.mcap"):
        (tmp_path / name).touch()
    (root / "link.mcap").symlink_to(tmp_path / "secret.mcap")
    return Folder.at(root)


def test_files_of_other_programs_are_to_be_imported(folder: Folder) -> None:
    assert folder.names(SUFFIX) == ["a.mcap"], "neither links nor what is in folders"
    shutil.copy(FOREIGN / "joint_states_0.mcap", folder.root / "bare.mcap")
    shutil.copy(SAMPLES / "fig5a.mcap", folder.root / "own.mcap")
    (folder.root / "scope.csv").touch()
    (folder.root / "bag").mkdir()
    (folder.root / "bag" / "metadata.yaml").touch()
    assert folder.foreign() == ["bag", "bare.mcap", "scope.csv"]
    assert folder.recordings() == ["a.mcap", "own.mcap"]
    for path in (folder.root / "bare.mcap", folder.root / "scope.csv"):
        session = open_session([path])
        assert session.recordings.train is session.recordings.validate is None, "they are not chosen"


def test_models_and_reports_are_listed_and_nothing_else_is_served(folder: Folder) -> None:
    for name in ("a.model.json", "a-2.model.json", "a.sealed.json", "a.diagnose-2.html", f"{LINK_PREFIX}x.html"):
        (folder.root / name).touch()
    (folder.root / "inner" / "b.report.html").touch()
    assert folder.models() == ["a-2.model.json", "a.model.json"]
    assert folder.reports() == ["a.diagnose-2.html"]
    assert folder.report("a.diagnose-2.html") == folder.root / "a.diagnose-2.html"
    for name in ("a.model.json", "inner/b.report.html", "../a.report.html", f"{LINK_PREFIX}x.html", "b.report.html"):
        with pytest.raises(BadInput, match="expected"):
            folder.report(name)


@pytest.mark.parametrize(
    "name",
    [
        *("../secret.mcap", "/etc/passwd", "inner/b.mcap", "link.mcap", "..", "", "a.mcap\0", "..\\secret.mcap"),
        *("C:\\a.mcap", "<img src=x onerror=window.hacked=1>.mcap", "missing.mcap", "x" * 5000),
    ],
)
def test_names_that_lead_outside_are_refused(name: str, folder: Folder) -> None:
    session = WorkbenchSession(folder)
    for use in (folder.existing_file, session.recordings.show, lambda name: session.choose(name, None)):
        with pytest.raises(BadInput, match="expected"):
            use(name)
    assert session.recordings.train is session.jobs.current is None


@pytest.mark.parametrize(
    "name", ["../new.mcap", "/tmp/new.mcap", ".hidden.mcap", "<script>.mcap", "new.py", "a.mcap", "link.mcap", SUFFIX]
)
def test_nothing_is_written_outside_or_overwritten(name: str, folder: Folder) -> None:
    with pytest.raises(BadInput):
        folder.new_file(name, SUFFIX)
    assert folder.new_file("new.mcap", SUFFIX) == folder.root / "new.mcap"
    assert folder.existing_file("a.mcap") == folder.root / "a.mcap"
    assert folder.free_name("a", SUFFIX) == "a-2.mcap"


def test_only_one_folder_can_be_opened(folder: Folder, tmp_path: Path) -> None:
    for paths in ([tmp_path / "nothing"], [tmp_path / "secret.mcap", folder.root / "a.mcap"], [Path(__file__)]):
        with pytest.raises(BadInput):
            open_session(paths)
    session = open_session([folder.root])
    assert session.recordings.train is None
    with pytest.raises(BadInput, match="another recording"):
        session.choose("a.mcap", "a.mcap")
    with pytest.raises(BadInput, match="none chosen"):
        session.selection.fit()


def test_pair_is_chosen_although_the_first_choice_was_deleted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in "abc":
        shutil.copy(SAMPLES / "fig5a.mcap", tmp_path / f"{name}.mcap")
    session = open_session([tmp_path])
    monkeypatch.setattr(session.recordings, "read", lambda: None)
    session.choose("a.mcap", None)
    (tmp_path / "a.mcap").unlink()
    session.choose_the_only_pair()
    assert (session.recordings.train, session.recordings.validate) == ("b.mcap", "c.mcap")


def test_pair_with_an_unsuitable_name_opens_and_says_why_it_is_not_chosen(tmp_path: Path) -> None:
    for name in ("a", "run 08:15"):
        shutil.copy(SAMPLES / "fig5a.mcap", tmp_path / f"{name}.mcap")
    session = open_session([tmp_path])
    assert session.recordings.train is None
    assert "a plain file name" in session.jobs.message
