"""Only what is new is analysed, with the same rows from any engine."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from ident.fleet.settings import FleetSettings
from ident.fleet.store import Store
from ident.fleet.update import Count, plan
from tests.ident.fleet.conftest import brought_up_to_date


@pytest.fixture
def folder(tmp_path: Path, night: Callable[..., Path]) -> Path:
    place = tmp_path / "recordings"
    place.mkdir()
    night(place / "a.mcap", 1)
    (place / "broken.mcap").write_bytes(b"nothing")
    (place / "copy.mcap").write_bytes(b"nothing")
    return place


def test_second_run_does_only_what_is_new(tmp_path: Path, folder: Path, night: Callable[..., Path]) -> None:
    store = Store(tmp_path / "store")
    count = brought_up_to_date(store, folder)
    assert counts(count) == (3, 2, 2)  # both broken files have a row
    ((path, reason),) = count.unused
    assert (Path(path).name, bool(reason)) == ("broken.mcap", True)
    first = store.table()
    assert counts(brought_up_to_date(store, folder)) == (3, 0, 2)
    assert store.table().equals(first)
    (folder / "again.mcap").write_bytes((folder / "a.mcap").read_bytes())
    night(folder / "b.mcap", 2)
    assert counts(brought_up_to_date(store, folder)) == (5, 1, 2)


def counts(count: Count) -> tuple[int, int, int]:
    return count.seen, count.new, count.failed


def test_other_settings_say_what_is_done_again(tmp_path: Path, folder: Path) -> None:
    store = Store(tmp_path / "store")
    assert plan_of(store, folder, FleetSettings()).outdated == 0
    brought_up_to_date(store, folder)
    work = plan_of(store, folder, FleetSettings(cutoff=20.0))
    assert (len(work.pending), work.outdated) == (2, 2)


def plan_of(store: Store, folder: Path, settings: FleetSettings) -> Any:
    with store.locked():
        return plan(store, [folder], settings)
