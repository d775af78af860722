"""A folder of pictures is written completely or not at all."""

from pathlib import Path

import pytest

from ident.output.plots.folder import staged_folder


def test_an_interrupted_write_leaves_no_files(tmp_path: Path) -> None:
    def interrupted() -> None:
        with staged_folder(tmp_path / "plots") as folder:
            (folder / "first.png").touch()
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert list(tmp_path.iterdir()) == []


def test_finished_pictures_are_added_to_the_folder(tmp_path: Path) -> None:
    plots = tmp_path / "deep" / "plots"
    for name in ("first.png", "second.png"):
        with staged_folder(plots) as folder:
            (folder / name).touch()
            assert not (plots / name).exists()
    assert sorted(path.name for path in plots.iterdir()) == ["first.png", "second.png"]
    assert list(plots.parent.iterdir()) == [plots]


def test_stale_pictures_are_deleted(tmp_path: Path) -> None:
    plots = tmp_path / "plots"
    plots.mkdir()
    for name in ("finding_1_old.png", "mine.png"):
        (plots / name).touch()
    with staged_folder(plots, ("finding_*.png",)) as folder:
        (folder / "finding_1_new.png").touch()
    assert sorted(path.name for path in plots.iterdir()) == ["finding_1_new.png", "mine.png"]
