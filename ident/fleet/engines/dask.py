"""Compute on a Dask cluster: one of this machine, or one that runs already. Paths travel, arrays do not."""

import logging
import signal
import threading
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
_WINDOW = 64
"""Items per worker that the scheduler knows of; a path is small."""
_SETTINGS = {"distributed.worker.profile.interval": "1s"}
"""Of a local cluster. Sampling 100 times a second where a worker is, which Dask does, takes a tenth of the time."""
_PATIENCE = 30
"""Time to reach a scheduler [s]."""
_MISSING = (
    "Dask needs the package distributed, which is not installed; install it with "
    "`pip install 'delta-workbench[fleet]'`, or use --engine processes"
)


def run(function: Callable[[T], R], items: Sequence[T], options: EngineOptions) -> Iterator[tuple[T, R | None]]:
    """See `Engine`.

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
        waiting = list(range(len(items)))[::-1]
        window = _WINDOW * max(len(client.scheduler_info(n_workers=-1)["workers"]), 1)
        running: dict[Any, int] = {}
        done = distributed.as_completed(loop=client.loop)
        while waiting or running:
            if waiting and len(running) <= window // 2:  # many at once: each message to the scheduler takes its time
                given = [waiting.pop() for _ in range(min(window - len(running), len(waiting)))]
                work = partial(alone, function)
                futures = client.map(work, [items[index] for index in given], pure=False, retries=TRIES - 1)
                running.update(zip(futures, given, strict=True))
                done.update(futures)
            future = next(done)
            yield items[running.pop(future)], _result(future, distributed)


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
            client = distributed.Client(
                options.scheduler, scheduler_file=options.scheduler_file, timeout=_PATIENCE, set_as_default=False
            )
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
