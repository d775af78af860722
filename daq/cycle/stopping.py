"""Stop requests by signals: one asks for an orderly stop, two for a quick stop."""

import signal
from types import FrameType, TracebackType
from typing import Self

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class StopRequest:
    """Counter of signals while the context is entered; the cycle polls it."""

    def __init__(self) -> None:
        self.count = 0
        """0: continue; 1: ramp down along the path; 2 and more: quick stop."""
        self.reason = ""
        self._before: dict[int, object] = {}
        self._signalled = False

    def ask(self, reason: str) -> None:
        """Request a stop; a second request asks for a quick stop."""
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
            # After a signal the program is about to end; further signals must not interrupt its last messages.
            signal.signal(number, signal.SIG_IGN if self._signalled else handler)  # type: ignore[arg-type]

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self._signalled = True
        self.ask(reason_of(signal.Signals(number)))


def reason_of(number: signal.Signals) -> str:
    """Reason of a stop by this signal."""
    return f"stopped by the operator ({number.name})"
