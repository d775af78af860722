import os
import signal

import pytest

from daq.stopping import StopRequest


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signals_are_counted_and_the_first_is_the_reason(number: signal.Signals) -> None:
    before = signal.getsignal(number)
    with StopRequest() as stop:
        assert stop.count == 0
        os.kill(os.getpid(), number)
        os.kill(os.getpid(), number)
        assert stop.count == 2
    assert stop.reason == f"stopped by the operator ({number.name})"
    assert signal.getsignal(number) is before
