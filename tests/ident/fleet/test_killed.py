"""Workers, scheduler and client are killed during a run; the next run ends it with the rows of an undisturbed one."""

import multiprocessing
import os
import signal
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from ident.fleet.engines import EngineOptions
from ident.fleet.store import Store
from recordings.errors import RunFailed
from tests.ident.fleet import cluster
from tests.ident.fleet.conftest import brought_up_to_date
from tests.patience import patient

RECORDINGS = 8
KILLED_AT = 3
"""Recording whose rows are being written when the client is killed."""
pytestmark = [pytest.mark.slow, pytest.mark.timeout(patient(300))]

Progress = Callable[[int, int], None]


def run(
    store: Path, folder: Path, engine: str, options: EngineOptions, progress: Progress = lambda done, total: None
) -> pa.Table:
    """Bring the `store` up to date, as `ident fleet` does, and return its rows."""
    brought_up_to_date(Store(store), folder, engine, options, progress)
    return Store(store).table()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, night: Callable[..., Path]) -> Path:
    """Recordings of one robot, and a broken one."""
    place = tmp_path_factory.mktemp("recordings")
    for number in range(RECORDINGS):
        night(place / f"{number}.mcap", number)
    (place / "broken.mcap").write_bytes(b"nothing")
    return place


@pytest.fixture(scope="module")
def undisturbed(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> pa.Table:
    return run(tmp_path_factory.mktemp("store"), folder, "serial", EngineOptions())


def number_of_recordings(table: pa.Table) -> int:
    return len(set(table["key"].to_pylist()))


@pytest.mark.parametrize(("engine", "workers"), [("processes", 1), ("processes", 3), ("dask", 1), ("dask", 2)])
def test_any_engine_and_number_of_workers_gives_the_same_rows(
    folder: Path, tmp_path: Path, undisturbed: pa.Table, engine: str, workers: int
) -> None:
    assert run(tmp_path / "store", folder, engine, EngineOptions(workers)).equals(undisturbed)


@pytest.mark.parametrize(("engine", "workers"), [("processes", 2), ("dask", 3)])
def test_workers_killed_at_random_change_nothing(
    folder: Path, tmp_path: Path, undisturbed: pa.Table, engine: str, workers: int
) -> None:
    rng, killed = np.random.default_rng(18), list[int]()

    def kill_one(done: int, total: int) -> None:
        if done in (2, 5):
            workers_now = multiprocessing.active_children()
            victim = workers_now[int(rng.integers(len(workers_now)))]
            victim.kill()
            killed.append(done)

    assert run(tmp_path / "store", folder, engine, EngineOptions(workers), kill_one).equals(undisturbed)
    assert killed == [2, 5]


def test_killed_client_leaves_no_worker_and_is_started_again(
    folder: Path, tmp_path: Path, undisturbed: pa.Table
) -> None:
    store, pids = tmp_path / "store", tmp_path / "pids"
    client = multiprocessing.get_context("spawn").Process(target=killed_client, args=(store, folder, pids))
    client.start()
    client.join(patient(120))
    assert client.exitcode == -signal.SIGKILL
    assert number_of_recordings(Store(store).table()) == KILLED_AT - 1
    assert len(list(store.rglob("*.part"))) == 1
    workers = list(map(int, pids.read_text().split()))
    assert workers
    deadline = time.monotonic() + patient(60)
    while any(map(is_running, workers)):
        assert time.monotonic() < deadline, "workers outlive the client that was killed"
        time.sleep(0.05)
    assert run(store, folder, "serial", EngineOptions()).equals(undisturbed)
    assert not list(store.rglob("*.part"))


def killed_client(store: Path, folder: Path, pids: Path) -> None:
    """Analyse, and be killed while rows are written; the process ids of the workers are left in a file."""
    flush, calls = os.fsync, list[int]()

    def flush_or_die(descriptor: int) -> None:
        calls.append(descriptor)
        if len(calls) == KILLED_AT:
            pids.write_text(" ".join(str(child.pid) for child in multiprocessing.active_children()))
            os.kill(os.getpid(), signal.SIGKILL)
        flush(descriptor)

    os.fsync = flush_or_die
    run(store, folder, "processes", EngineOptions(2))


def is_running(pid: int) -> bool:
    """Whether the process is there, and more than an entry for its parent."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_lost_scheduler_is_said_and_the_next_run_goes_on(folder: Path, tmp_path: Path, undisturbed: pa.Table) -> None:
    with cluster.started(workers=1) as joined:

        def kill_scheduler(done: int, total: int) -> None:
            if done == KILLED_AT:
                joined.scheduler.kill()

        with pytest.raises(RunFailed, match="the scheduler was lost"):
            run(tmp_path / "store", folder, "dask", joined.options, kill_scheduler)
    kept = number_of_recordings(Store(tmp_path / "store").table())
    assert KILLED_AT <= kept < RECORDINGS + 1
    assert run(tmp_path / "store", folder, "processes", EngineOptions(2)).equals(undisturbed)
