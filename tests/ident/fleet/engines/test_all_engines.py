"""Every engine gives the same results, survives its workers, and is found by its name."""

import os
import resource
import signal
from pathlib import Path

import dask.config
import numpy as np
import pytest

from ident.fleet import engines
from ident.fleet.engines import EngineOptions
from recordings.errors import BadInput

LOCAL = EngineOptions(workers=2)


def square(number: int) -> int:
    return number * number


def deadly(item: tuple[int, Path]) -> int:
    """Kill the worker: at 3 always, at 5 once."""
    number, folder = item
    mark = folder / str(number)
    if number == 3 or (number == 5 and not mark.exists()):
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number * number


def threads(number: int) -> str:
    return os.environ["NUMBA_NUM_THREADS"]


def new_pages(number: int) -> int:
    """Return how many pages the kernel had to clear for arrays of 1 MiB, of which each is freed before the next."""
    before = resource.getrusage(resource.RUSAGE_THREAD).ru_minflt
    for _ in range(20):
        np.ones(2**17)
    return resource.getrusage(resource.RUSAGE_THREAD).ru_minflt - before


@pytest.mark.slow
@pytest.mark.parametrize("name", ["processes", "dask"])
def test_workers_use_freed_memory_again(name: str) -> None:
    *_, last = engines.load(name).run(new_pages, range(5), EngineOptions(workers=1))
    one_array = 2**20 // resource.getpagesize()
    assert last[1] is not None
    assert last[1] < 2 * one_array


@pytest.mark.slow
@pytest.mark.parametrize("name", ["processes", "dask"])
def test_workers_have_one_thread_and_this_process_is_left_as_it_was(name: str) -> None:
    before = os.environ.get("NUMBA_NUM_THREADS")
    assert dict(engines.load(name).run(threads, [1, 2], LOCAL)) == {1: "1", 2: "1"}
    assert os.environ.get("NUMBA_NUM_THREADS") == before


@pytest.mark.parametrize(
    "name",
    ["serial", pytest.param("processes", marks=pytest.mark.slow), pytest.param("dask", marks=pytest.mark.slow)],
)
def test_every_item_has_its_result(name: str) -> None:
    results = dict(engines.load(name).run(square, range(30), LOCAL))
    assert results == {number: number * number for number in range(30)}


@pytest.mark.slow
def test_of_several_items_given_to_a_dask_worker_only_what_kills_it_is_given_up(tmp_path: Path) -> None:
    items = [(number + (number > 3), tmp_path) for number in range(-400, 200)]  # -400 … 3, 5 … 200
    results = dict(engines.load("dask").run(deadly, items, LOCAL))
    assert results == {item: None if item[0] == 3 else item[0] ** 2 for item in items}


@pytest.mark.slow
def test_process_that_dies_is_replaced_and_only_what_kills_each_time_is_given_up(tmp_path: Path) -> None:
    items = [(number, tmp_path) for number in range(12)]
    results = dict(engines.load("processes").run(deadly, items, LOCAL))
    assert results == {item: None if item[0] == 3 else item[0] ** 2 for item in items}


def test_scheduler_that_does_not_exist_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ident.fleet.engines.dask._PATIENCE", 0.2)
    with pytest.raises(BadInput, match=r"a Dask scheduler at tcp://127\.0\.0\.1:9 expected"):
        list(engines.load("dask").run(square, [1], EngineOptions(scheduler="tcp://127.0.0.1:9")))


def test_encryption_needs_the_settings_of_dask(tmp_path: Path) -> None:
    (tmp_path / "scheduler.json").write_text('{"address": "tls://127.0.0.1:9"}')
    none, tls = str(tmp_path / "none.pem"), "distributed.comm.tls"
    for told in (
        EngineOptions(scheduler="tls://127.0.0.1:9"),
        EngineOptions(scheduler_file=tmp_path / "scheduler.json"),
    ):
        with pytest.raises(BadInput, match=r"^Dask's TLS settings expected .*COMM__TLS__CA_FILE"):
            list(engines.load("dask").run(square, [1], told))
        with (
            dask.config.set(dict.fromkeys((f"{tls}.ca-file", f"{tls}.client.cert", f"{tls}.client.key"), none)),
            pytest.raises(BadInput, match=r"certificates and a key .* expected, .*No such file.* check its settings"),
        ):
            list(engines.load("dask").run(square, [1], told))
