"""Jobs of the page: tasks of the worker process that can be watched and cancelled."""

import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ident.workbench.topics import Changes
from ident.workbench.worker.process import Message, StatusText, TaskEnd, Worker, WorkerEnd
from ident.workbench.worker.views import View
from recordings.errors import BadInput

Receiver = Callable[[View], None]
"""Takes the views of a task, in a separate thread."""


@dataclass(frozen=True)
class Job:
    """What the worker executes."""

    text: str
    start_time: float
    blocking: bool
    """Whether no other job can be started before it ends."""
    task: str = ""
    expected: float | None = None
    """Time that the same task took when it was last completed [s]; None: it was not."""

    @property
    def seconds(self) -> float:
        """Return the time taken so far [s]."""
        return time.monotonic() - self.start_time

    @property
    def progress(self) -> str:
        """Return the time taken, and share and remaining time if the task takes as long as the last time."""
        seconds, left = f"{self.seconds:.0f} s", (self.expected or 0.0) - self.seconds
        if self.expected is None or left <= 0:
            return seconds
        return f"{seconds}, {self.seconds / self.expected:.0%}, about {left:.0f} s left"


class Jobs:
    """The current job, the tasks that the worker has not finished, and the last message to the user."""

    def __init__(self, changes: Changes, effect_files: Sequence[Path]) -> None:
        self._changes = changes
        self.current: Job | None = None
        self.durations: dict[str, float] = {}
        """Time that each task took when it was last completed [s]."""
        self.message = ""
        self.on_end: list[Callable[[bool], None]] = []
        """Called when nothing is left to do, with whether the last task was completed."""
        self.worker = Worker(self.receive, effect_files)
        self._receivers: deque[Receiver] = deque()
        """Receivers of the tasks that the worker has not finished."""

    @property
    def blocked(self) -> bool:
        """Whether no other blocking job can be started now."""
        return self.current is not None and self.current.blocking

    def submit(self, text: str, receive: Receiver, task: str, *arguments: object, blocking: bool = True) -> None:
        """Send `task` to the worker.

        Raises:
            BadInput: both jobs are blocking.
        """
        with self.worker.lock:
            self.check_free(blocking)
            # The worker finishes the view that it computes, so that a blocking job goes on blocking others.
            expected = self.durations.get(task)
            self.current = Job(text, time.monotonic(), blocking or self.blocked, task, expected)
            self._receivers.append(receive)
            self._changes.mark("job")
            self.show_message("")
            self.worker.submit(task, *arguments)

    def check_free(self, blocking: bool = True) -> None:
        """Refuse a `blocking` job while the current one is blocking."""
        job = self.current
        if job and job.blocking and blocking:
            raise BadInput(f"no other job expected, '{job.text}' is in progress; wait for it, or cancel it")

    def unblock(self) -> None:
        """Let other jobs interrupt the current one, unless the view that has come is of the job before."""
        if self.current and len(self._receivers) == 1:
            self.current = replace(self.current, blocking=False)

    def stop(self) -> None:
        """End the worker; the next task starts another one."""
        with self.worker.lock:
            self.worker.cancel()
            self._receivers.clear()
            self.current = None
            self._changes.mark("job")

    def cancel(self) -> None:
        """Cancel the current job; earlier results stay."""
        with self.worker.lock:
            if job := self.current:
                stays = "nothing has changed" if job.blocking else "what is shown stays"
                self._abort(f"Cancelled ({job.text}); {stays}.")

    def _abort(self, message: str) -> None:
        self.stop()
        self.show_message(message)
        self._end(completed=False)

    def show_message(self, text: str) -> None:
        """Show `text` to the user."""
        self.message = text
        self._changes.mark("message")

    def receive(self, message: Message) -> None:
        """Take a message of the worker."""
        match message:
            case StatusText(text):
                if self.current:
                    self.current = replace(self.current, text=text)
            case TaskEnd(error):
                self._receivers.popleft()
                if error:
                    self.show_message(error)
                if not self._receivers:
                    if error is None and self.current:
                        self.durations[self.current.task] = self.current.seconds
                    self.current = None
                    self._end(completed=error is None)
            case WorkerEnd(error):
                self._abort(error)
            case view:
                self._receivers[0](view)
        self._changes.mark("job")

    def _end(self, completed: bool) -> None:
        for callback in self.on_end:
            try:
                callback(completed)
            except BadInput as error:  # such as a recording that was deleted meanwhile
                self.show_message(str(error))
