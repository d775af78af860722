"""Keep-alives of hold-to-run: their end is a signal, their presence none."""

import os
import signal
from collections.abc import Iterator

import pytest

from daq.commissioning import hold as module
from daq.commissioning.hold import START_TIMEOUT, TIMEOUT, HoldToRun
from daq.cycle.progress import CycleProgress
from daq.cycle.stopping import StopRequest
from tests.simulated_time import SimulatedTime, simulate_time


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> SimulatedTime:
    return simulate_time(monkeypatch, module)


@pytest.fixture
def pipe() -> Iterator[tuple[int, int]]:
    reading, writing = os.pipe()
    yield reading, writing
    os.close(reading)
    os.close(writing)


def held(clock: SimulatedTime, source: int, phase: str = "stream") -> float:
    """Time after which the run is stopped [s]."""
    begin = clock.now
    hold = HoldToRun(CycleProgress(phase=phase), source)
    with StopRequest() as stop:
        hold._run_thread()
    assert hold.released
    assert stop.reason == f"stopped by the operator ({signal.Signals.SIGTERM.name})"
    return clock.now - begin


@pytest.mark.parametrize(("phase", "timeout"), [("start", START_TIMEOUT), ("approach", TIMEOUT), ("stream", TIMEOUT)])
@pytest.mark.parametrize("presses", [0, 10])
def test_run_goes_on_as_long_as_keep_alives_come_in_time(
    clock: SimulatedTime, pipe: tuple[int, int], phase: str, timeout: float, presses: int
) -> None:
    """One comes shortly before the timeout after the other."""
    for k in range(1, presses + 1):
        clock.at(0.95 * k * timeout, lambda: os.write(pipe[1], b" "))
    assert held(clock, pipe[0], phase) == pytest.approx((0.95 * presses + 1) * timeout, abs=0.03)


def test_end_of_the_input_stops_the_run_at_once(clock: SimulatedTime) -> None:
    reading, writing = os.pipe()
    clock.at(0.1, lambda: os.close(writing))
    assert held(clock, reading) == pytest.approx(0.1)
    os.close(reading)


def test_keep_alives_from_before_the_run_do_not_count(clock: SimulatedTime, pipe: tuple[int, int]) -> None:
    os.write(pipe[1], b" " * 5000)
    assert held(clock, pipe[0]) == pytest.approx(TIMEOUT, abs=0.03)


def test_a_run_that_has_ended_is_not_stopped(pipe: tuple[int, int]) -> None:
    with StopRequest() as stop, HoldToRun(CycleProgress(phase="stream"), pipe[0]) as hold:
        pass
    assert (stop.count, hold.released) == (0, False)
