"""Cycles and what is recorded of them."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from daq.cycle.clock import LockstepClock
from daq.cycle.exchange import RecordedExchange
from daq.cycle.progress import CycleProgress
from daq.cycle.stopping import StopRequest
from drivers.protocol import Power, Sample
from recordings.rig import simulated_rig

RIG = simulated_rig().at_rate(100.0)
ANSWER = Sample(
    position=(0.1, 0.2, 0.3),
    voltage=(1.0,) * 3,
    statusword=(0,) * 3,
    error_code=(0,) * 3,
    power=(Power.ON,) * 3,
    missing=1,
    trouble=None,
)
TARGET = np.array([0.1, 0.2, 0.4])


class Drives:
    """Drives that give the same answer to every SYNC."""

    sync: int | None = None

    def exchange(self, setpoint: Any, timeout: float) -> Sample:
        return replace(ANSWER, sync=self.sync)


class LateClock(LockstepClock):
    """Clock of a host that comes late to SYNC 1."""

    late = 0.0

    def overdue(self, index: int) -> float:
        return self.late if index == 1 else 0.0


class Rows:
    """Recorder that keeps its rows in memory."""

    def __init__(self) -> None:
        self.rows: list[tuple[Any, ...]] = []
        self.events: list[str] = []

    def cycle(self, *row: Any) -> None:
        self.rows.append(row)

    def event(self, log_ns: int, level: str, source: str, message: str) -> None:
        self.events.append(message)


class Bench:
    def __init__(self, feedforward: bool = False) -> None:
        self.drives, self.clock, self.rows = Drives(), LateClock(RIG.rate), Rows()
        self.stop, self.progress = StopRequest(), CycleProgress()
        self.exchange = RecordedExchange(
            RIG,
            self.drives,  # type: ignore[arg-type]
            self.clock,
            self.rows,  # type: ignore[arg-type]
            self.stop,
            self.progress,
            feedforward=feedforward,
        )


def test_cycle_is_recorded_with_its_target_and_counted() -> None:
    bench = Bench()
    bench.exchange.without_target()
    assert bench.exchange.run("setpoint", TARGET, 2) == ANSWER
    (_, _, first, no_repeat, _, no_command, *_), (stamp, _, second, repeat, _, command, *_) = bench.rows.rows
    assert (first, no_repeat, second, repeat, stamp) == (0, -1, 1, 2, 10_000_000)
    assert np.isnan(no_command).all()
    assert command is TARGET
    assert (bench.progress.cycles, bench.progress.lost, bench.progress.missed) == (2, 2, 0)
    assert bench.exchange.time == pytest.approx(0.02)


@pytest.mark.parametrize("feedforward", [False, True])
def test_run_with_feedforward_has_an_offset_in_every_cycle(feedforward: bool) -> None:
    bench = Bench(feedforward)
    bench.exchange.without_target()
    offset = bench.rows.rows[0][-1]
    assert (offset is not None and offset.tolist() == [0.0] * 3) if feedforward else offset is None


@pytest.mark.parametrize("late_by", ["host", "kernel"])
def test_missed_syncs_are_recorded_as_gaps(late_by: str) -> None:
    bench = Bench()
    bench.exchange.without_target()
    if late_by == "host":
        bench.clock.late = 0.031
    else:
        bench.drives.sync = 4
    bench.exchange.run("setpoint", TARGET)
    assert [row[2] for row in bench.rows.rows] == [0, 1, 2, 3, 4]
    assert all(math.isnan(row[7].position[0]) and row[7].missing == 3 for row in bench.rows.rows[1:4])
    assert bench.progress.missed == 3
    assert bench.rows.events == [f"host {31.0 if late_by == 'host' else 0.0} ms late, 3 missed"]
    assert bench.stop.count == 0


def test_long_stall_of_the_host_asks_for_a_stop() -> None:
    bench = Bench()
    bench.exchange.without_target()
    bench.clock.late = 0.08
    bench.exchange.run("setpoint", TARGET)
    assert bench.stop.count == 1
    assert "80 ms late, 50 ms allowed" in bench.stop.reason
