"""Stores and recordings are the same in a folder, by file:// and in an object store; one program at a time writes."""

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pyarrow.compute as pc
import pytest

from ident.diagnosis.diagnosis import DiagnosisOptions
from ident.fleet import alarms, places
from ident.fleet.cause import cause_between
from ident.fleet.follow import rebuild
from ident.fleet.places import files, one_writer, place, reached, source, whole
from ident.fleet.store import Store
from ident.fleet.walk import walk
from ident.program import program
from recordings.errors import BadInput
from recordings.reader import read
from recordings.recording import Recording
from tests import running
from tests.ident.fleet.conftest import brought_up_to_date, filled, recordings_of, rows_of

invoke = partial(running.ran, program, "fleet")


class Killed(BaseException):
    """Ends a program in the middle."""


@pytest.fixture
def memory() -> Iterator[Path]:
    """A folder in an object store of this process; nothing is in the store."""
    folder = place("memory://bucket/fleet")
    yield folder
    for name in folder.fs.ls("/", detail=False):
        folder.fs.rm(name, recursive=True)


@pytest.fixture(params=["path", "file", "memory"])
def folder(request: pytest.FixtureRequest, tmp_path: Path, memory: Path) -> Path:
    """A place of each kind where nothing is."""
    path = tmp_path / "fleet"
    return {"path": path, "file": place(f"file://{path}"), "memory": memory}[request.param]


def put(where: Path, content: bytes = b"") -> None:
    with whole(where) as partial:
        partial.write_bytes(content)


def test_second_writer_is_refused_and_the_next_one_is_not(folder: Path) -> None:
    with Store(folder).locked(), pytest.raises(BadInput, match="in use by another"), Store(folder).locked():
        pass
    with Store(folder).locked():
        assert Store(folder).table().num_rows == 0


@pytest.mark.parametrize("written", [2, 4, 6])
def test_kill_at_any_file_loses_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch, written: int) -> None:
    rows, left = rows_of("r01", {"c_c1": np.arange(4.0)}), iter(range(written))
    undisturbed = filled(place("memory://bucket/undisturbed"), rows).table()

    def killed(where: Path) -> object:
        if next(left, None) is None:
            raise Killed
        return whole(where)

    with monkeypatch.context() as patch:
        for module in ("store", "places"):
            patch.setattr(f"ident.fleet.{module}.whole", killed)
        with pytest.raises(Killed):
            filled(folder, rows)
    known = set(Store(folder).table()["key"].to_pylist())
    assert len(known) == min(written, 4)
    store = filled(folder, *[each for each in recordings_of(rows) if each[0]["key"] not in known])
    assert store.table().equals(undisturbed)
    rebuild(store, rows[0]["settings"])
    assert store.table().equals(undisturbed)


def test_foreign_folder_and_a_place_without_store_are_refused(folder: Path) -> None:
    with pytest.raises(BadInput, match="none found"):
        Store(folder).table()
    put(folder / "thesis.tex")
    with pytest.raises(BadInput, match=r"'thesis\.tex' found"), Store(folder).locked():
        pass


def test_file_is_whole_or_as_it_was(folder: Path) -> None:
    put(folder / "a.json", b"one")
    with pytest.raises(Killed), whole(folder / "a.json") as partial:  # noqa: PT012
        partial.write_bytes(b"tw")
        raise Killed
    assert [(path.name, path.read_bytes()) for path in folder.iterdir()] == [("a.json", b"one")]


def test_recordings_of_an_object_store_give_the_rows_of_a_folder(
    memory: Path, tmp_path: Path, night: Callable[..., Path]
) -> None:
    folder = tmp_path / "recordings"
    folder.mkdir()
    night(folder / "0.mcap", 0)
    (folder / "broken.mcap").write_bytes(b"nothing")
    (folder / "notes.txt").write_text("")
    for path in folder.iterdir():
        put(memory / "r01" / path.name, path.read_bytes())
    usable = {}
    for name, where in {"files": folder, "objects": memory}.items():
        store = Store(tmp_path / name)
        assert [brought_up_to_date(store, where).new for _ in range(2)] == [2, 0]
        table = store.table()
        usable[name] = table.filter(pc.equal(table["status"], "done")).drop_columns(["path", "changed"])
    assert usable["objects"].num_rows > 10
    assert usable["objects"].equals(usable["files"])
    (reason,) = filter(None, table["reason"].to_pylist())
    assert "memory://bucket/fleet/r01/broken.mcap" in reason
    assert source(folder / "0.mcap") == folder / "0.mcap"
    found = source(memory / "r01" / "0.mcap")
    assert isinstance(found, Recording)
    assert (str(found.path), found.digest) == ("memory://bucket/fleet/r01/0.mcap", read(folder / "0.mcap").digest)


def test_object_that_is_gone_leaves_an_alarm_without_cause(memory: Path) -> None:
    found = cause_between(
        [memory / "0.mcap"], [memory / "1.mcap"], (2,), DiagnosisOptions(), lambda names: np.ones(1)
    )
    assert "memory://bucket/fleet/0.mcap cannot be read" in found.why
    assert found.after == ("memory://bucket/fleet/1.mcap",)


def test_state_of_an_object_saves_fetching_it(memory: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put(memory / "a.mcap", b"one")
    (first,) = walk([memory])
    known = {(str(first.path), first.size, first.changed): "known"}
    assert [file.content for file in walk([memory], known)] == ["known"]
    put(memory / "a.mcap", b"two")
    (changed,) = walk([memory], known)
    assert changed.content not in ("known", first.content)


def test_command_with_urls_leads_to_a_page_on_this_machine(memory: Path, tmp_path: Path) -> None:
    put(memory / "broken.mcap", b"nothing")
    store = "memory://bucket/store"
    for new in (1, 0):
        assert f"1 recordings, {new} of them new; 1 cannot be used" in invoke(memory, "--store", store).output
    assert f"--store {store} -o store.html" in invoke(memory, "--store", store).output
    invoke("report", "--store", store, "-o", tmp_path / "page.html")
    assert str(memory / "broken.mcap") in (tmp_path / "page.html").read_text(encoding="utf-8")
    with pytest.raises(BadInput, match=f"{store}: a folder of recordings expected, a store"):
        invoke(store, "--store", store)


def test_lock_of_a_killed_program_says_whose_it_is_and_how_it_goes(memory: Path) -> None:
    lock = one_writer(memory)
    lock.__enter__()
    with pytest.raises(
        BadInput, match=r"process \d+ on .* since 20.*Z; wait .* or remove memory://bucket/fleet/.lock"
    ):
        one_writer(memory).__enter__()
    (memory / ".lock").unlink()
    with one_writer(memory):
        pass


def test_object_store_that_ignores_conditions_is_refused(memory: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory.fs, "pipe_file", lambda path, value, mode: memory.fs.touch(path))
    with pytest.raises(BadInput, match="conditional puts"), one_writer(memory):
        pass
    assert not (memory / ".lock").exists()


def refused(*_: object, **__: object) -> None:
    raise RuntimeError("Unable to locate\ncredentials")


def test_what_cannot_be_reached_is_said_in_one_sentence(memory: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(BadInput, match=r"ftp://host/x: a path, s3:// or gs:// expected, ftp:// found"):
        invoke("ftp://host/x", "--store", "store")
    monkeypatch.setattr(places, "find_spec", lambda name: None)
    for protocol, extra in (("gs", "gs"), ("s3", "s3"), ("memory", "s3")):
        with pytest.raises(BadInput, match=rf"needs .* not installed; .* `pip install 'delta-workbench\[{extra}\]'`"):
            place(f"{protocol}://bucket/x")
    monkeypatch.undo()
    for method in ("info", "pipe_file", "put_file", "get_file", "find"):
        monkeypatch.setattr(type(memory.fs), method, refused)
    for attempt in (
        put,
        source,
        files,
        lambda where: one_writer(where).__enter__(),
        lambda where: reached(str(where)),
    ):
        with pytest.raises(BadInput, match=r"cannot be .*: Unable to locate credentials; check"):
            attempt(memory)


class NoEndpoint(Exception):
    """As botocore's own, which are no OSErrors."""


NoEndpoint.__module__ = "botocore.exceptions"


def fails(error: Exception) -> Callable[..., None]:
    def failing(*_: object, **__: object) -> None:
        raise error

    return failing


@pytest.mark.parametrize(
    ("error", "expected", "said"),
    [
        (
            NoEndpoint("Could not connect"),
            BadInput,
            "the object store cannot be reached: Could not connect; check .* run again",
        ),
        (ZeroDivisionError("ours"), ZeroDivisionError, "ours"),
    ],
)
def test_store_that_is_lost_while_it_is_asked_is_said_in_one_sentence(
    error: Exception, expected: type[Exception], said: str, memory: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(type(memory.fs), "isdir", fails(error))
    for arguments in ((memory,), ("report", "-o", "page.html"), ("rebuild",)):
        with pytest.raises(expected, match=said):
            invoke(*arguments, "--store", "memory://bucket/store")


def test_object_of_a_lost_store_is_not_called_damaged(memory: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store = filled(memory, rows_of("r01", {"c_c1": np.arange(2.0)}))
    put(memory / "fleet.json", b"{}")
    monkeypatch.setattr(type(memory.fs), "open", fails(ConnectionError("lost")))
    for read_from in (Store.table, alarms.load):
        with pytest.raises(BadInput, match="cannot be read: lost; check its name"):
            read_from(store)
