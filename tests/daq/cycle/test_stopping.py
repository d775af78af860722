import os
import signal
from collections.abc import Iterator

import pytest

from daq.cycle.stopping import SIGNALS, StopRequest


@pytest.fixture(autouse=True)
def _restored() -> Iterator[None]:
    """After a signal all of them are ignored, which would outlast the test."""
    before = {number: signal.getsignal(number) for number in SIGNALS}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signals_are_counted_and_the_first_is_the_reason(number: signal.Signals) -> None:
    with StopRequest() as stop:
        assert stop.count == 0
        os.kill(os.getpid(), number)
        os.kill(os.getpid(), number)
        assert stop.count == 2
    assert stop.reason == f"stopped by the operator ({number.name})"
    # The program is about to end: further signals are ignored.
    assert all(signal.getsignal(each) is signal.SIG_IGN for each in SIGNALS)


def test_signal_handlers_are_restored_without_a_signal() -> None:
    before = signal.getsignal(signal.SIGINT)
    with StopRequest() as stop:
        stop.ask("the host came late")
    assert signal.getsignal(signal.SIGINT) is before
