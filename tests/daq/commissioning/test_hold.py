"""Keep-alives of hold-to-run: their end is a signal, their presence none."""

import os
import signal
import threading
import time
from collections.abc import Iterator

import pytest

from daq.commissioning.hold import TIMEOUT, HoldToRun
from daq.cycle.progress import CycleProgress
from daq.cycle.stopping import StopRequest
from tests.patience import patient


@pytest.fixture
def pipe() -> Iterator[tuple[int, int]]:
    reading, writing = os.pipe()
    yield reading, writing
    os.close(reading)


def wait_for(stop: StopRequest, timeout: float = 10.0) -> None:
    deadline = time.monotonic() + patient(timeout)
    while not stop.count and time.monotonic() < deadline:
        time.sleep(0.01)


@pytest.mark.parametrize(("phase", "ends"), [("start", True), ("stream", False)])
def test_end_of_the_keep_alives_stops_the_run(pipe: tuple[int, int], phase: str, ends: bool) -> None:
    """Of the input, or only of what comes over it."""
    with StopRequest() as stop, HoldToRun(CycleProgress(phase=phase), pipe[0]) as hold:
        assert stop.count == 0
        if ends:
            os.close(pipe[1])
        wait_for(stop)
    assert hold.released
    assert stop.count == 1
    if not ends:
        os.close(pipe[1])


def test_keep_alives_keep_it_moving(pipe: tuple[int, int]) -> None:
    let_go = threading.Event()

    def press() -> None:
        while not let_go.wait(TIMEOUT / 10):
            os.write(pipe[1], b" ")

    with StopRequest() as stop, HoldToRun(CycleProgress(phase="stream"), pipe[0]) as hold:
        key = threading.Thread(target=press)
        key.start()
        time.sleep(2 * TIMEOUT)
        held = (stop.count, hold.released)
        let_go.set()
        key.join()
    assert held == (0, False)
    os.close(pipe[1])


def test_keep_alives_from_before_the_run_do_not_count(pipe: tuple[int, int]) -> None:
    os.write(pipe[1], b" " * 5000)
    os.close(pipe[1])
    with StopRequest() as stop, HoldToRun(CycleProgress(phase="stream"), pipe[0]):
        wait_for(stop)
    assert stop.reason == f"stopped by the operator ({signal.Signals.SIGTERM.name})"
