"""Recordings are found at any depth, and known ones are not read again."""

from pathlib import Path

import pytest

from ident.fleet.walk import walk
from recordings.errors import BadInput


def test_finds_recordings_at_any_depth_sorted_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "r02" / "june").mkdir(parents=True)
    for name in ("r02/june/b.mcap", "a.mcap", "a.part.mcap", "a.mcap.part", ".hidden.mcap", "notes.txt"):
        (tmp_path / name).write_text(name)
    assert [file.path.name for file in walk([tmp_path])] == ["a.mcap", "b.mcap"]
    assert len(list(walk([tmp_path, tmp_path / "r02"]))) == 2  # a folder inside another one counts once


def test_known_state_saves_reading_and_another_state_does_not(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_text("one")
    (first,) = walk([tmp_path])
    known = {(str(first.path), first.size, first.changed): "known"}
    (again,) = walk([tmp_path], known)
    assert again.content == "known"
    path.write_text("another")
    (changed,) = walk([tmp_path], known)
    assert changed.content not in ("known", first.content)


def test_missing_folder_is_refused_and_a_dangling_link_is_a_file_without_content(tmp_path: Path) -> None:
    (tmp_path / "gone.mcap").symlink_to(tmp_path / "nowhere")
    assert [file.content for file in walk([tmp_path])] == [""]
    with pytest.raises(BadInput, match="a folder of recordings expected"):
        list(walk([tmp_path / "none"]))
