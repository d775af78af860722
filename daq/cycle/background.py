"""A thread beside the cycle, which never waits for it."""

import threading
from abc import ABC, abstractmethod
from types import TracebackType
from typing import Self


class BackgroundThread(ABC):
    """A thread that runs from the beginning of a `with` block to its end."""

    def __init__(self, name: str) -> None:
        self._finished = threading.Event()
        """Set at the end of the block."""
        self._thread = threading.Thread(target=self._run_thread, name=name, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._finished.set()
        self._thread.join()

    @abstractmethod
    def _run_thread(self) -> None:
        """Work until `_finished` is set; nothing is left to do when it returns."""
