"""Bring a store up to date: analyse what is new below the folders, with any engine."""

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import pyarrow.compute as pc

from ident.fleet import engines
from ident.fleet.engines import EngineOptions
from ident.fleet.follow import settle
from ident.fleet.recording_rows import Row, examine, failure
from ident.fleet.settings import FleetSettings
from ident.fleet.store import Store
from ident.fleet.walk import RecordingFile, walk

_DIED = "its worker died each time, perhaps for want of memory"


@dataclass(frozen=True)
class Plan:
    """What is to be done."""

    seen: int
    """Files below the folders."""
    pending: tuple[RecordingFile, ...]
    """New ones, each content once."""
    copies: dict[str, tuple[RecordingFile, ...]]
    """The others of the same content."""
    outdated: int
    """Of them, those that were analysed before with other settings or another version of the method."""


@dataclass(frozen=True)
class Count:
    """What was done."""

    seen: int
    new: int
    failed: int
    """In the store, with these settings."""
    unused: tuple[tuple[str, str], ...]
    """Paths of the new ones that cannot be used, and why."""


def plan(store: Store, folders: Sequence[Path], settings: FleetSettings) -> Plan:
    """Compare the folders with the `store`.

    Raises:
        BadInput: a folder does not exist, or the store is damaged.
    """
    table = store.index()
    keys = set(table["key"].to_pylist())
    others = table.filter(pc.not_equal(table["settings"], settings.digest))
    outdated = set(others["content"].to_pylist())
    files = list(walk(folders, store.known_contents(table)))
    groups: dict[str, list[RecordingFile]] = defaultdict(list)
    for file in files:
        if not {settings.key(file.content), settings.key(file.content, str(file.path))} & keys:
            groups[file.content or str(file.path)].append(file)
    pending = tuple(group[0] for group in groups.values())
    copies = {group[0].content: tuple(group[1:]) for group in groups.values()}
    return Plan(len(files), pending, copies, sum(file.content in outdated for file in pending))


def update(
    store: Store,
    work: Plan,
    settings: FleetSettings,
    engine: str,
    options: EngineOptions,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Count:
    """Analyse what is pending and keep each result as soon as it is there."""
    new = 0
    unused: list[tuple[str, str]] = []
    for rows in _results(work.pending, settings, engine, options):
        store.add(rows)
        new += 1
        if rows[0]["status"] == "failed":
            unused.append((rows[0]["path"], rows[0]["reason"]))
            for copy in work.copies.get(rows[0]["content"], ()):
                store.add([failure(copy, settings, rows[0]["reason"])])
        progress(new, len(work.pending))
    settle(store)
    table = store.index()
    failed = pc.and_(pc.equal(table["status"], "failed"), pc.equal(table["settings"], settings.digest))
    return Count(work.seen, new, pc.sum(failed).as_py() or 0, tuple(unused))


def _results(
    files: Sequence[RecordingFile], settings: FleetSettings, engine: str, options: EngineOptions
) -> Iterator[list[Row]]:
    function = partial(examine, settings=settings)
    for file, rows in engines.load(engine).run(function, files, options):
        yield [failure(file, settings, _DIED)] if rows is None else rows
