"""Worker process: holds the recordings, executes the fits, and is controlled through a pipe.

The page never waits for it and can end it at any time. A new task interrupts the current one and its
remaining views are skipped.
"""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

from ident.workbench.worker.views import View


@dataclass(frozen=True)
class StatusText:
    """What the worker does now."""

    text: str


@dataclass(frozen=True)
class TaskEnd:
    """A task has ended; `error` says why it failed."""

    error: str | None = None


@dataclass(frozen=True)
class WorkerEnd:
    """The process has ended by itself, and with it all tasks."""

    error: str


Message = View | StatusText | TaskEnd | WorkerEnd
"""What the worker sends to the page."""


class Worker:
    """The worker process; started with the first task."""

    def __init__(self, on_message: Callable[[Message], None], effect_files: Sequence[Path]) -> None:
        """`on_message`: called from a separate thread with every message."""
        self._on_message, self._effect_files = on_message, tuple(effect_files)
        self._process: multiprocessing.process.BaseProcess | None = None
        self._connection: Connection | None = None
        self.lock = threading.RLock()
        """Held while a message is handled, so that submitting and cancelling see a consistent state."""

    def submit(self, task: str, *arguments: object) -> None:
        """Send `task` to the engine; results arrive as messages."""
        with self.lock:
            self.prepare()
            assert self._connection is not None
            self._connection.send((task, arguments))

    def prepare(self) -> None:
        """Start the process early, because importing its libraries takes time."""
        with self.lock:
            if self._process is not None and self._process.is_alive():
                return
            context = multiprocessing.get_context("spawn")  # a fork would share the server's sockets
            page_end, worker_end = context.Pipe()
            process = context.Process(target=_run_tasks, args=(worker_end, self._effect_files), daemon=True)
            process.start()
            worker_end.close()
            self._process, self._connection = process, page_end
            threading.Thread(target=self._listen, args=(process, page_end), name="worker", daemon=True).start()

    def cancel(self) -> None:
        """Kill the process."""
        with self.lock:
            process, self._process, self._connection = self._process, None, None
        if process is not None:
            process.kill()
            process.join()

    def _listen(self, process: multiprocessing.process.BaseProcess, connection: Connection) -> None:
        try:
            while True:
                self._deliver(process, connection.recv())
        except (EOFError, OSError):
            self._deliver(process, WorkerEnd("The worker process has ended unexpectedly; check the free memory."))

    def _deliver(self, process: multiprocessing.process.BaseProcess, message: Message) -> None:
        with self.lock:
            if self._process is process:  # not cancelled meanwhile
                self._on_message(message)


def _run_tasks(connection: Connection, effect_files: Sequence[Path]) -> None:
    """Execute tasks in the worker process until the pipe is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is handled by the server, which ends this process
    threading.Thread(target=_end_with_server, daemon=True).start()
    from ident.workbench.worker.engine import SelectionEngine
    from recordings.errors import BadInput

    try:
        engine = SelectionEngine(lambda text: connection.send(StatusText(text)), effect_files)
        while True:
            task, arguments = connection.recv()
            try:
                for view in getattr(engine, task)(*arguments):
                    connection.send(view)
                    if connection.poll():
                        break
                connection.send(TaskEnd())
            except BadInput as error:
                connection.send(TaskEnd(str(error)))
            except Exception as error:  # errors caused by a recording or a user's effect must not end the page
                connection.send(TaskEnd(f"{type(error).__name__}: {error}"))
    except (EOFError, ConnectionError):
        return


def _end_with_server() -> None:
    """End this process when the server has been killed: a restarted one has a worker of its own."""
    server = multiprocessing.parent_process()
    assert server is not None
    server.join()
    os._exit(1)
