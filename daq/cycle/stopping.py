"""Stop requests by signals: one asks for an orderly stop, two for a quick stop."""

import signal
from types import FrameType, TracebackType
from typing import Self

from recordings.errors import BadInput

SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""That ask a program to end, as far as the system has them."""


def check_stoppable() -> None:
    """Check that another process can ask this one to stop; where it can only kill it, real drives would stay enabled.

    Raises:
        BadInput: the system, as Windows, has no such signals.
    """
    if not hasattr(signal, "SIGHUP"):
        raise BadInput(
            "real drives: a system on which a program can be asked to stop, as Linux, expected, none found; "
            "use one, or simulated drives"
        )


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
        for number in SIGNALS:
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
