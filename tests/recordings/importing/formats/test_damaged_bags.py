"""Bags of other programs that are cut off or damaged: what is intact is read, and what is lost is said."""

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as BagWriter

from recordings.errors import BadInput
from recordings.importing.formats import read
from recordings.recovery import rewrite
from tests.recordings.importing.formats.test_ros import STORE, TYPE, message

COUNT, START, STEP = 900, 1_767_600_000 * 10**9, 4_000_000
SMALL = 20_000
KINDS: dict[str, dict[str, Any]] = {
    "one chunk": {"compression": CompressionType.NONE},
    "chunks": {"compression": CompressionType.NONE, "chunk_size": SMALL},
    "zstd": {"compression": CompressionType.ZSTD, "chunk_size": SMALL},
    "lz4": {"compression": CompressionType.LZ4, "chunk_size": SMALL},
    "one chunk of zstd": {"compression": CompressionType.ZSTD},
    "no chunks": {"use_chunking": False},
    "no checksums": {"enable_crcs": False, "chunk_size": SMALL},
    "no channels in the summary": {"repeat_channels": False, "repeat_schemas": False, "chunk_size": SMALL},
}
"""How other programs write MCAP."""


@cache
def contents() -> list[bytes]:
    stamps = (START + k * STEP for k in range(COUNT))
    states = (message(stamp, ("a", "b"), (k / 7, -k), (1.0, k % 5)) for k, stamp in enumerate(stamps))
    return [bytes(STORE.serialize_cdr(each, TYPE)) for each in states]


def write(path: Path, first: int = 0, last: int = COUNT, **how: Any) -> bytes:
    """An MCAP file as another program writes it."""
    with path.open("wb") as stream:
        writer = Writer(stream, **how)
        writer.start("ros2", "another program")
        text = STORE.generate_msgdef(TYPE, ros_version=2)[0]
        channel = writer.register_channel(
            "/joint_states", "cdr", writer.register_schema(TYPE, "ros2msg", text.encode())
        )
        for k in range(first, last):
            writer.add_message(channel, START + k * STEP, contents()[k], START + k * STEP)
        writer.finish()
    return path.read_bytes()


def bag(path: Path, plugin: StoragePlugin) -> None:
    with BagWriter(path, version=9, storage_plugin=plugin) as writer:
        topic = writer.add_connection("/joint_states", TYPE, typestore=STORE)
        for k, content in enumerate(contents()):
            writer.write(topic, START + k * STEP, content)


def right_rows(path: Path) -> tuple[int, str]:
    """Number of rows of the bag, all of which are right, and its notes."""
    table = read(path)
    k = np.round(table.column("time") * 1e9 / STEP)
    np.testing.assert_allclose(table.column("position_1"), k / 7, atol=1e-9)
    np.testing.assert_allclose(table.column("effort_2"), k % 5, atol=1e-9)
    return table.count, "; ".join(table.notes[1:])


@pytest.mark.parametrize("kind", KINDS)
def test_what_was_written_before_a_cut_is_read(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    whole = write(path, **KINDS[kind])
    assert right_rows(path) == (COUNT, "")
    packed_at_once = kind == "one chunk of zstd"
    for share in (0.6, 0.95) if packed_at_once else (0.37, 0.6, 0.95):
        size = int(share * len(whole))
        path.write_bytes(whole[:size] + bytes(100_000 * (share == 0.6)))  # zeros: after a power failure
        rows, notes = right_rows(path)
        assert rows > (0 if packed_at_once else 0.9 * share * COUNT)
        assert f"a.mcap is cut off or damaged: {rows} messages of {(rows - 1) * STEP / 1e9:.3f} s are intact" in notes
        assert "lost are an unknown number of messages" in notes
        assert path.read_bytes()[:size] == whole[:size]
    for missing in (5, 30):  # the end alone
        path.write_bytes(whole[:-missing])
        rows, notes = right_rows(path)
        assert rows == COUNT
        assert "is cut off" in notes


@pytest.mark.parametrize("kind", ["chunks", "zstd", "lz4", "no chunks", "no checksums"])
def test_what_is_intact_around_damage_is_read(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    whole = write(path, **KINDS[kind])
    middle = len(whole) // 2
    for damaged in (whole[:middle] + bytes(3000) + whole[middle + 3000 :], whole[:middle] + whole[middle + 777 :]):
        path.write_bytes(damaged)
        rows, notes = right_rows(path)
        assert COUNT / 3 < rows <= COUNT
        assert f"{rows} messages" in notes
        assert f"lost are {COUNT - rows} messages" in notes


def mcap_in(folder: Path) -> Path:
    return max(folder.glob("*.mcap"))


def cut(folder: Path, share: float, suffix: str = ".mcap") -> None:
    file = max(folder.glob(f"*{suffix}"))
    file.write_bytes(file.read_bytes()[: int(share * file.stat().st_size)])


def split(folder: Path, *names: str) -> None:
    folder.mkdir()
    for number, name in enumerate(names):
        write(folder / name, 300 * number, 300 * (number + 1), chunk_size=SMALL)


def changed(folder: Path, plugin: StoragePlugin, metadata: str | None) -> None:
    bag(folder, plugin)
    file = folder / "metadata.yaml"
    if metadata is None:
        file.unlink()
    else:
        file.write_text(metadata.replace("HALF", file.read_text()[:200]))


MCAP, SQLITE = StoragePlugin.MCAP, StoragePlugin.SQLITE3
LISTED = "the files in it were read, without metadata.yaml"
FOLDERS: dict[str, tuple[Callable[[Path], Any], int, str]] = {
    "MCAP without metadata": (lambda path: changed(path, MCAP, None), COUNT, LISTED),
    "SQLite without metadata": (lambda path: changed(path, SQLITE, None), COUNT, LISTED),
    "MCAP, half of its metadata": (lambda path: changed(path, MCAP, "HALF"), COUNT, LISTED),
    "SQLite, half of its metadata": (lambda path: changed(path, SQLITE, "HALF"), COUNT, LISTED),
    "empty metadata": (lambda path: changed(path, MCAP, ""), COUNT, LISTED),
    "metadata of another kind": (lambda path: changed(path, MCAP, "- a"), COUNT, LISTED),
    "metadata of zeros": (lambda path: changed(path, MCAP, "\0" * 100), COUNT, LISTED),
    "a renamed file": (lambda path: (bag(path, MCAP), mcap_in(path).rename(path / "b.mcap")), COUNT, LISTED),
    "a recorder that was killed": (lambda path: (changed(path, MCAP, None), cut(path, 0.6)), 500, "is cut off"),
    "a copy that was interrupted": (lambda path: (bag(path, MCAP), cut(path, 0.6)), 500, "is cut off"),
    "parts": (lambda path: split(path, "a_0.mcap", "a_1.mcap", "a_2.mcap"), COUNT, LISTED),
    "parts, the last one cut": (lambda path: (split(path, "a_0.mcap", "a_1.mcap"), cut(path, 0.5)), 360, "a_1.mcap"),
    "parts, the last one empty": (
        lambda path: (split(path, "a_0.mcap", "a_1.mcap"), cut(path, 0)), 300, "left out: .*a_1.mcap is empty"
    ),
}  # fmt: skip
"""Folders, the number of rows that are at least read, and what a note says."""


@pytest.mark.parametrize("name", FOLDERS)
def test_a_folder_is_its_files(name: str, tmp_path: Path) -> None:
    make, least, note = FOLDERS[name]
    make(tmp_path / "bag")
    rows, notes = right_rows(tmp_path / "bag")
    assert least <= rows <= COUNT
    assert re.search(note, notes)


REFUSED: dict[str, tuple[Callable[[Path], Any], str]] = {
    "an empty folder": (lambda path: path.mkdir(), "a folder that is no bag found; name a file in it"),
    "two bags": (lambda path: split(path, "a.mcap", "b.mcap"), "files of one bag, expected, a.mcap, b.mcap found"),
    "metadata alone": (lambda path: (bag(path, MCAP), mcap_in(path).unlink()), "files are missing"),
    "nothing intact": (lambda path: (split(path, "a.mcap"), cut(path, 0.01)), "a.mcap holds no intact data"),
    "a cut database": (lambda path: (bag(path, SQLITE), cut(path, 0.6, ".db3")), "cannot be read as a ROS bag"),
    "half a page": (lambda path: (bag(path, SQLITE), cut(path, 0.999, ".db3")), "cannot be read as a ROS bag"),
    "an empty database": (lambda path: (bag(path, SQLITE), cut(path, 0, ".db3")), "cannot be read as a ROS bag"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_holds_nothing_is_refused(name: str, tmp_path: Path) -> None:
    make, reason = REFUSED[name]
    make(tmp_path / "bag")
    with pytest.raises(BadInput, match=reason):
        read(tmp_path / "bag")


@pytest.mark.parametrize("kind", KINDS)
def test_rewritten_file_stays_one_of_the_other_program(kind: str, tmp_path: Path) -> None:
    whole = write(tmp_path / "a.mcap", **KINDS[kind])
    (tmp_path / "a.mcap").write_bytes(whole[: int(0.6 * len(whole))])
    kept = rewrite(tmp_path / "a.mcap", tmp_path / "b.mcap", {"exit_status": "1"})
    assert (kept.foreign, kept.whole, kept.lost_records) == (True, False, ())
    assert right_rows(tmp_path / "b.mcap") == (kept.messages, "")
    assert b"another program" in (tmp_path / "b.mcap").read_bytes()
    again = rewrite(tmp_path / "b.mcap", tmp_path / "c.mcap", {})
    assert (again.foreign, again.whole, again.messages) == (True, True, kept.messages)
