"""The store: each recording once, whole or not at all, one run at a time."""

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ident.fleet.recording_rows import Row
from ident.fleet.store import SCHEMA, Store
from recordings.errors import BadInput
from tests.ident.fleet.conftest import filled, rows_of


@pytest.fixture
def nights() -> list[list[Row]]:
    """Rows of six recordings."""
    flat = rows_of("r01", {"c_c1": np.arange(6.0)})
    return [flat[i : i + 2] for i in range(0, 12, 2)]


def test_table_is_the_same_in_any_order_and_when_it_is_settled(tmp_path: Path, nights: list[list[Row]]) -> None:
    table = filled(tmp_path / "a", *nights).table()
    assert table.schema.equals(SCHEMA)
    assert table.num_rows == 12
    other = filled(tmp_path / "b", *nights[3:])
    with other.locked():
        for rows in nights[:3]:
            other.add(rows)
    assert other.table().num_rows == 12
    assert other.index().num_rows == 6
    assert filled(tmp_path / "b").table().drop_columns("motion_number").equals(table.drop_columns("motion_number"))
    assert [path.name for path in (tmp_path / "b" / "recordings").rglob("*.parquet")] == ["2026-01.parquet"]


@pytest.mark.parametrize("robot", ["..", "a/b", "-", "ä b", None])
def test_robot_of_any_name_has_a_file(tmp_path: Path, nights: list[list[Row]], robot: str | None) -> None:
    status = "done" if robot else "failed"
    store = filled(tmp_path / "a", [{**nights[0][0], "robot": robot, "status": status}])
    (path,) = (tmp_path / "a" / "recordings").glob("*/2026-01.parquet")
    assert store.table()["robot"].to_pylist() == [robot]
    assert path.resolve().parent.parent == tmp_path / "a" / "recordings"


def test_partly_written_file_and_one_of_an_old_store_are_no_part_of_the_table(
    tmp_path: Path, nights: list[list[Row]]
) -> None:
    store = filled(tmp_path / "a", *nights)
    (tmp_path / "a" / "recordings" / "one-x.parquet.part").write_bytes(b"PAR1")
    (tmp_path / "a" / "recordings" / "many-x.parquet").write_bytes(b"PAR1")
    assert store.table().num_rows == 12
    (tmp_path / "a" / "recordings" / "one-x.parquet").write_bytes(b"PAR1")
    with pytest.raises(BadInput, match=r"one-x.parquet is damaged .*remove it"):
        store.table()


def test_store_on_a_disk_that_is_really_full_goes_on_when_there_is_room(tmp_path: Path) -> None:
    namespace = ["unshare", "-rm"]
    probe = [*namespace, "mount", "-t", "tmpfs", "none", str(tmp_path)]
    if shutil.which("unshare") is None or subprocess.run(probe, capture_output=True, check=False).returncode:
        pytest.skip("a disk of its own needs `unshare -rm` and `mount`, which are not there or not allowed")
    code = f"from tests.ident.fleet.test_store import fill_a_disk; fill_a_disk({str(tmp_path)!r})"
    done = subprocess.run([*namespace, sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def fill_a_disk(place: str) -> None:
    """Keep recordings on a disk of 64 KiB until it is full, and go on when it is larger."""
    flat, disk = rows_of("r01", {"c_c1": np.arange(40.0)}), Path(place)
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "none", disk], check=True)
    store = Store(disk / "store")
    with store.locked():
        first = 0
        with pytest.raises(BadInput, match="the disk is full; what it holds is kept"):  # noqa: PT012
            while True:
                store.add(flat[first : first + 2])
                first += 2
        assert store.table().num_rows == first > 0
        assert not list(disk.rglob("*.part"))
        subprocess.run(["mount", "-o", "remount,size=1m", disk], check=True)
        store.add(flat[first : first + 2])
        assert store.table().num_rows == first + 2


def test_second_run_and_foreign_folders_are_refused(tmp_path: Path) -> None:
    with Store(tmp_path / "a").locked(), pytest.raises(BadInput, match="in use"), Store(tmp_path / "a").locked():
        pass
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "thesis.tex").write_text("")
    with pytest.raises(BadInput, match=r"'thesis.tex' found"), Store(tmp_path / "b").locked():
        pass
    with pytest.raises(BadInput, match="none found"):
        Store(tmp_path / "c").table()
