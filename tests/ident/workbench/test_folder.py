"""The page has access only to files of the chosen folder."""

from pathlib import Path

import pytest

from ident.workbench.folder import SUFFIX, Folder
from ident.workbench.session import open_session
from recordings.errors import BadInput


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
