"""Work beside the page: one process that has the recordings and fits, asked through a pipe.

The page never waits for it, and may end it at any time. What it was asked last comes first: looks that nobody waits
for any more are left out.
"""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Literal

Kind = Literal["progress", "shown", "failed", "idle"]
Said = Callable[[Kind, Any], None]
"""Called from a thread of its own with what the work says."""


class Work:
    """The process, started when there is something to do."""

    def __init__(self, said: Said, effect_files: Sequence[Path]) -> None:
        self._said, self._effect_files = said, tuple(effect_files)
        self._process: multiprocessing.process.BaseProcess | None = None
        self._connection: Connection | None = None
        self.lock = threading.RLock()
        """Held while something is said, so that who asks, pauses or cancels does not meet it halfway."""

    @property
    def fresh(self) -> bool:
        """Whether the process, if there is any, knows nothing of what was done before."""
        return self._process is None or not self._process.is_alive()

    def ask(self, task: str, *arguments: Any) -> None:
        """Let the engine do `task`; what comes of it is said."""
        with self.lock:
            if self.fresh:
                self._start()
            assert self._connection is not None
            self._connection.send((task, arguments))

    def prepare(self) -> None:
        """Start the process before it is needed: its libraries take a moment."""
        with self.lock:
            if self.fresh:
                self._start()

    def pause(self) -> None:
        """Let it stand still, whatever it does."""
        self._signal(signal.SIGSTOP)

    def resume(self) -> None:
        """Let it go on where it stood."""
        self._signal(signal.SIGCONT)

    def cancel(self) -> None:
        """End it, whatever it does."""
        with self.lock:
            process, self._process, self._connection = self._process, None, None
        if process is not None:
            process.kill()  # one that stands still hears nothing else
            process.join()

    def _signal(self, number: signal.Signals) -> None:
        with self.lock:
            if self._process is not None and self._process.is_alive():
                assert self._process.pid is not None
                os.kill(self._process.pid, number)

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")  # a fork would share the server's sockets
        ours, theirs = context.Pipe()
        process = context.Process(target=_serve, args=(theirs, self._effect_files), daemon=True)
        process.start()
        theirs.close()
        self._process, self._connection = process, ours
        threading.Thread(target=self._listen, args=(process, ours), name="work", daemon=True).start()

    def _listen(self, process: multiprocessing.process.BaseProcess, connection: Connection) -> None:
        try:
            while True:
                self._say(process, *connection.recv())
        except (EOFError, OSError):
            self._say(process, "failed", "The process that computes has ended by itself; is the memory full?")

    def _say(self, process: multiprocessing.process.BaseProcess, kind: Kind, value: Any) -> None:
        with self.lock:
            if self._process is process:  # not cancelled meanwhile
                self._said(kind, value)


def _serve(connection: Connection, effect_files: Sequence[Path]) -> None:
    """In the process: do what is asked until the other side has gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the server, which ends this process
    from ident.workbench.engine import Engine
    from recordings.errors import BadInput

    try:
        engine = Engine(
            lambda text: connection.send(("progress", text)),
            effect_files,
            lambda descent: connection.send(("shown", descent)),
        )
        while True:
            task, arguments = connection.recv()
            try:
                for shown in getattr(engine, task)(*arguments):
                    connection.send(("shown", shown))
                    if connection.poll():
                        break
                connection.send(("idle", None))
            except BadInput as error:
                connection.send(("failed", str(error)))
            except Exception as error:  # whatever a recording or a user's effect makes of it: the page goes on
                connection.send(("failed", f"{type(error).__name__}: {error}"))
    except (EOFError, BrokenPipeError):
        return
