"""The page has access only to files of the chosen folder."""

import shutil
from pathlib import Path

import pytest

from ident.workbench.folder import SUFFIX, Folder
from ident.workbench.session import open_session
from recordings.errors import BadInput

SAMPLES = Path("recordings/samples").resolve()
FOREIGN = SAMPLES / "foreign"


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    root = tmp_path / "runs"
    root.mkdir()
    (root / "a.mcap").touch()
    (tmp_path / "secret.mcap").touch()
    (root / "link.mcap").symlink_to(tmp_path / "secret.mcap")
    (root / "inner").mkdir()
    (root / "inner" / "b.mcap").touch()
    return Folder.at(root)


def test_only_recordings_directly_in_the_folder_are_listed(folder: Folder) -> None:
    assert folder.names(SUFFIX) == ["a.mcap"]


def test_files_of_other_programs_are_to_be_imported(folder: Folder) -> None:
    shutil.copy(FOREIGN / "joint_states_0.mcap", folder.root / "bare.mcap")
    shutil.copy(SAMPLES / "fig5a.mcap", folder.root / "own.mcap")
    (folder.root / "scope.csv").touch()
    (folder.root / "bag").mkdir()
    (folder.root / "bag" / "metadata.yaml").touch()
    assert folder.foreign() == ["bag", "bare.mcap", "scope.csv"]
    assert folder.recordings() == ["a.mcap", "own.mcap"]


def test_files_of_other_programs_are_not_chosen(tmp_path: Path) -> None:
    bare = shutil.copy(FOREIGN / "joint_states_0.mcap", tmp_path / "bare.mcap")
    scope = shutil.copy(FOREIGN / "scope-fig5a.csv", tmp_path / "scope.csv")
    shutil.copy(SAMPLES / "fig5a.mcap", tmp_path / "own.mcap")
    for paths in ([tmp_path], [bare], [scope]):
        session = open_session(paths)
        assert session.recordings.train is session.recordings.validate is None
        session.close()


@pytest.mark.parametrize(
    "name",
    [
        "../secret.mcap",
        "/etc/passwd",
        "inner/b.mcap",
        "link.mcap",
        "..",
        "",
        ".",
        "a.mcap\0",
        "..\\secret.mcap",
        "C:\\a.mcap",
        "%2e%2e/secret.mcap",
        "missing.mcap",
        "x" * 5000,
    ],
)
def test_names_that_lead_outside_are_refused(name: str, folder: Folder) -> None:
    with pytest.raises(BadInput):
        folder.existing_file(name)


@pytest.mark.parametrize(
    "name", ["../new.mcap", "/tmp/new.mcap", ".hidden.mcap", "<script>.mcap", "new.py", "a.mcap", "link.mcap", SUFFIX]
)
def test_nothing_is_written_outside_or_overwritten(name: str, folder: Folder) -> None:
    with pytest.raises(BadInput):
        folder.new_file(name, SUFFIX)


def test_new_and_existing_file(folder: Folder) -> None:
    assert folder.new_file("new.mcap", SUFFIX) == folder.root / "new.mcap"
    assert folder.existing_file("a.mcap") == folder.root / "a.mcap"


def test_only_one_folder_can_be_opened(folder: Folder, tmp_path: Path) -> None:
    for paths in ([tmp_path / "nothing"], [tmp_path / "secret.mcap", folder.root / "a.mcap"], [Path(__file__)]):
        with pytest.raises(BadInput):
            open_session(paths)
    session = open_session([folder.root])
    assert session.recordings.train is None
    session.close()


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
    session.close()
