import pytest

from daq.cycle import clock as module
from daq.cycle.clock import HostClock, LockstepClock
from tests.simulated_time import SimulatedTime, simulate_time


@pytest.fixture
def time(monkeypatch: pytest.MonkeyPatch) -> SimulatedTime:
    return simulate_time(monkeypatch, module, oversleep=1e-4)


def test_host_stamps_are_evenly_spaced_however_late_the_host_is(time: SimulatedTime) -> None:
    clock = HostClock(1000.0)
    clock.wait(0)
    time.sleep(0.005)
    late = clock.wait(1)
    assert late == pytest.approx(0.0041)
    assert clock.stamp(2) - clock.stamp(1) == clock.stamp(1) - clock.stamp(0) == 1_000_000


def test_host_deadlines_do_not_drift(time: SimulatedTime) -> None:
    clock = HostClock(1000.0)
    before = time.perf_counter()
    clock.wait(0)
    time.sleep(0.003)
    for k in range(1, 21):
        clock.wait(k)
    # Twenty periods after the first one, although the host overslept three of them.
    assert time.perf_counter() - before == pytest.approx(0.0201)
    assert clock.overdue(20) == pytest.approx(1e-4)


def test_cycle_begins_before_its_sync_by_the_lead(time: SimulatedTime) -> None:
    clock = HostClock(1000.0, lead=4e-4)
    clock.wait(0)
    began = time.time_ns()
    assert clock.stamp(0) - began == pytest.approx(4e5, abs=1e3)
    assert clock.stamp(1) - clock.stamp(0) == 1_000_000


@pytest.mark.parametrize(("rate", "timeout"), [(1000.0, 0.85e-3), (100.0, 9e-3), (30.0, 1 / 30 - 1e-3)])
def test_answer_timeout_is_the_period_without_the_host_share(rate: float, timeout: float) -> None:
    clock = HostClock(rate)
    assert clock.answer_timeout == pytest.approx(timeout)
    assert clock.overdue(0) == 0.0, "nothing is overdue before the first cycle"


def test_lost_answers_in_lockstep_cost_seconds_not_minutes() -> None:
    clock, waited = LockstepClock(250.0), 0.0
    longest = clock.answer_timeout
    for _ in range(113):  # a run that ends because a drive is lost, with its stop and power-off
        waited += clock.answer_timeout
        clock.note_answers(1)
    assert waited < 2 * longest + 113 * 0.05 + 0.1
    clock.note_answers(0)
    assert clock.answer_timeout == longest
