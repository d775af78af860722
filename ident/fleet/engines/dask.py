"""Compute on a Dask cluster: one of this machine, or one that runs already. Paths travel, arrays do not."""

import logging
import math
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any, TypeVar

from ident.fleet.engines import ONE_THREAD, TRIES, EngineOptions, alone
from recordings.errors import BadInput, RunFailed

T = TypeVar("T")
R = TypeVar("R")
MEMORY = "2 GiB"
"""Memory of each worker of a local cluster."""
_WINDOW = 8
"""Tasks per worker that the scheduler knows of."""
_MOMENT = 0.5
"""Time of a task, and of what is lost with it [s]; one item may take longer."""
_MOST = 32
"""Items of a task."""
_SETTINGS = {
    "distributed.worker.profile.interval": "1s",
    "distributed.worker.memory.monitor-interval": "500ms",
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "2s",
}
"""Of a local cluster. Dask samples 100 times a second where a worker is, which takes a tenth of its time, and asks
each event loop 50 times a second whether it still runs: 2 % of each worker's time and 4 % of this process's. The
memory of workers is looked at twice a second, not ten times, and the load of the machine, for which each process
reads /proc, every other second: a quarter of what Dask needs otherwise."""
_PATIENCE = 30
"""Time to reach a scheduler [s]."""
_MISSING = (
    "Dask needs the package distributed, which is not installed; install it with "
    "`pip install 'delta-workbench[fleet]'`, or use --engine processes"
)


def run(function: Callable[[T], R], items: Sequence[T], options: EngineOptions) -> Iterator[tuple[T, R | None]]:
    """See `Engine`. What is short is given out several at a time, because each message takes some milliseconds.

    Raises:
        BadInput: Dask is not installed, or the scheduler cannot be reached.
        RunFailed: the scheduler was lost.
    """
    try:
        import distributed
    except ImportError:
        raise BadInput(_MISSING) from None
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # what it reports is reported below
    with _client(options) as client:
        options.say(f"dashboard: {client.dashboard_link}")
        workers = max(len(client.scheduler_info(n_workers=-1)["workers"]), 1)
        waiting, suspected = deque(range(len(items))), deque[int]()
        running: dict[Any, list[int]] = {}
        done, fastest, examined = distributed.as_completed(loop=client.loop), math.inf, False
        while waiting or suspected or running:
            given: list[list[int]] = []
            if suspected and not running:  # one by one, as a worker that dies takes all that it was given with it
                given, examined = [[suspected.popleft()]], True
            elif not suspected and len(running) <= _WINDOW * workers // 2:  # many at once: each message takes time
                given, examined = list(_tasks(waiting, _WINDOW * workers - len(running), workers, fastest)), False
            if given:
                tasks = [[items[index] for index in task] for task in given]
                futures = client.map(partial(_all, function), tasks, pure=False, retries=TRIES - 1)
                running.update(zip(futures, given, strict=True))
                done.update(futures)
            future = next(done)
            task = running.pop(future)
            result = _result(future, distributed)
            if result is None and not examined:
                suspected += task
                continue
            results, seconds = result or ([None], math.inf)
            fastest = min(fastest, seconds)
            yield from zip((items[index] for index in task), results, strict=True)


def _tasks(waiting: deque[int], most: int, workers: int, seconds: float) -> Iterator[list[int]]:
    """Take up to `most` tasks from what is `waiting`.

    A task takes a moment, and in the end so little that no worker has much more to do than the others.

    seconds: time that an item takes.
    """
    for _ in range(most):
        if waiting:
            count = min(int(_MOMENT / max(seconds, _MOMENT / _MOST)), len(waiting) // (2 * workers))
            yield [waiting.popleft() for _ in range(max(count, 1))]


def _all(function: Callable[[T], R], items: Sequence[T]) -> tuple[list[R], float]:
    """Results of a task's `items`, and the time for each [s]."""
    begin = time.monotonic()
    return [alone(function, item) for item in items], (time.monotonic() - begin) / len(items)


def _result(future: Any, distributed: Any) -> Any:
    try:
        return future.result()
    except distributed.scheduler.KilledWorker:
        return None
    except (distributed.client.FutureCancelledError, OSError, TimeoutError) as error:
        raise RunFailed(
            f"the scheduler was lost ({type(error).__name__}); what was done is kept. Start it, and run again"
        ) from None


@contextmanager
def _client(options: EngineOptions) -> Iterator[Any]:
    import dask.config
    import distributed

    if options.scheduler or options.scheduler_file:
        where = options.scheduler or options.scheduler_file
        try:
            _check_encryption(options)
            client = distributed.Client(
                options.scheduler, scheduler_file=options.scheduler_file, timeout=_PATIENCE, set_as_default=False
            )
        except BadInput:
            raise
        except (OSError, ValueError, TimeoutError) as error:
            raise BadInput(f"a Dask scheduler at {where} expected, none reached: {error}; start it first") from None
        with client:
            yield client
        return
    with _interrupt_ignored(), dask.config.set(_SETTINGS):
        cluster = distributed.LocalCluster(
            n_workers=options.workers,
            threads_per_worker=1,
            memory_limit=MEMORY,
            env=ONE_THREAD,
            dashboard_address="127.0.0.1:0",
            silence_logs=logging.CRITICAL,
        )
    with cluster, distributed.Client(cluster, set_as_default=False) as client:
        yield client


def _check_encryption(options: EngineOptions) -> None:
    """Refuse a scheduler that speaks TLS where Dask has no settings for that: its client would wait for a minute."""
    from distributed.security import Security

    told = options.scheduler_file.read_text(encoding="utf-8") if options.scheduler_file else options.scheduler
    if "tls://" not in str(told):
        return
    try:
        context = Security().get_connection_args("client")["ssl_context"]
    except OSError as error:
        raise BadInput(
            f"certificates and a key for Dask's TLS expected, {error} found; check its settings comm.tls.ca-file, "
            "comm.tls.client.cert and comm.tls.client.key"
        ) from None
    if context is None:
        raise BadInput(
            "Dask's TLS settings expected for a tls:// address, none found; set DASK_DISTRIBUTED__COMM__TLS__CA_FILE "
            "and likewise CLIENT__CERT and CLIENT__KEY, or a file of Dask's configuration"
        )


@contextmanager
def _interrupt_ignored() -> Iterator[None]:
    """Let processes that are started meanwhile ignore Ctrl-C: this one ends them in order."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
