"""How a run is asked to stop from outside: once for an orderly stop, twice for a stop at once."""

import signal
from types import FrameType, TracebackType
from typing import Self

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class StopRequest:
    """Collects signals while it is entered; the cycle looks at it."""

    def __init__(self) -> None:
        self.count = 0
        """0: run on; 1: ramp down along the motion; 2 and more: quick stop."""
        self.reason = ""
        self._before: dict[int, object] = {}
        self._signalled = False

    def ask(self, reason: str) -> None:
        """Ask for a stop, or more urgently if it has been asked for already."""
        self.count += 1
        self.reason = self.reason or reason

    def __enter__(self) -> Self:
        for number in _SIGNALS:
            self._before[number] = signal.signal(number, self._on_signal)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, handler in self._before.items():
            # A program that a signal has stopped is on its way out; more of them must not spoil its last words.
            signal.signal(number, signal.SIG_IGN if self._signalled else handler)  # type: ignore[arg-type]

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self._signalled = True
        self.ask(f"stopped by the operator ({signal.Signals(number).name})")
