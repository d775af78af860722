"""All ways in which a run can end, on simulated drives that are perfect or misbehave on purpose."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from daq.cycle.clock import LockstepClock
from daq.cycle.exchange import RunParts
from daq.cycle.progress import CycleProgress
from daq.cycle.stopping import StopRequest
from daq.cycle.stream import Stream
from drivers.protocol import Goal, Power, Sample
from recordings.errors import RunFailed
from recordings.rig import simulated_rig
from trajectories import load

RIG = simulated_rig().at_rate(100.0)
TRAJECTORY = load("fig5a", RIG, cycles=1)


Interference = Callable[["PerfectDrives", int, Sample], Sample]


class PerfectDrives:
    """Drives that reach every target at the next SYNC; `interfere` may change an answer or raise."""

    def __init__(self, interfere: Interference | None = None) -> None:
        self.goal = Goal.DISABLED
        self.power = Power.OFF
        self.position = np.array([0.3, 0.3, 0.3])
        self.goals: list[Goal] = []
        self.positions: list[NDArray[np.float64]] = []
        self._interfere = interfere
        self._stopping = 0

    def encode(self, targets: NDArray[np.float64], torque: NDArray[np.float64] | None = None) -> Sequence[Any]:
        return list(targets)

    def exchange(self, setpoint: Any, timeout: float) -> Sample:
        assert timeout > 0
        self.goals.append(self.goal)
        self.positions.append(self.position.copy())
        if self.goal is Goal.ENABLED:
            self.power = Power.ON
        elif self.power is Power.ON and self.goal is Goal.STOPPED:
            self.power, self._stopping = Power.STOPPING, 5
        elif self.power is Power.STOPPING and self._stopping:
            self._stopping -= 1
        else:
            self.power = Power.OFF
        sample = Sample(
            position=tuple(self.position.tolist()),
            voltage=(1.0,) * 3,
            statusword=(0,) * 3,
            error_code=(0,) * 3,
            power=(self.power,) * 3,
            missing=0,
            trouble=None,
        )
        if setpoint is not None and self.power is Power.ON:
            self.position = np.array(setpoint)
        return sample if self._interfere is None else self._interfere(self, len(self.goals), sample)

    def power_off(self) -> tuple[Power, ...]:
        self.powered_off = True
        return self.found_by_power_off

    def fault_details(self) -> str:
        return self.details

    details = ""
    powered_off = False
    found_by_power_off = (Power.UNKNOWN,) * 3

    def stands_disabled(self) -> bool:
        return self.power is Power.OFF and self.goals[-1] is Goal.DISABLED


class Rows:
    """Recorder that keeps its rows in memory."""

    def __init__(self) -> None:
        self.progress = CycleProgress()
        self.rows: list[tuple[Any, ...]] = []
        self.events: list[str] = []
        self.error: RunFailed | None = None

    def cycle(self, *row: Any) -> None:
        self.rows.append(row)

    def event(self, log_ns: int, level: str, source: str, message: str) -> None:
        self.events.append(message)


def stream(drives: PerfectDrives, clock: Any = None, stop: StopRequest | None = None) -> tuple[Stream, Rows]:
    rows = Rows()
    clock, stop = clock or LockstepClock(RIG.rate), stop or StopRequest()
    return Stream(RunParts(RIG, drives, clock, rows, stop, rows.progress)), rows  # type: ignore[arg-type]


def test_complete_run_follows_the_trajectory_smoothly_and_ends_disabled() -> None:
    drives = PerfectDrives()
    run, rows = stream(drives)
    run.run(TRAJECTORY)
    assert drives.stands_disabled()
    streamed = [row for row in rows.rows if row[6] is not None]
    np.testing.assert_array_equal([row[5] for row in streamed], TRAJECTORY.joint_position)
    np.testing.assert_array_equal([row[3] for row in streamed], TRAJECTORY.repeat)
    assert [row[:3] for row in rows.rows] == [(10_000_000 * k, 10_000_000 * k, k) for k in range(len(rows.rows))]
    assert np.isnan(rows.rows[0][5]).all(), "no target before power"
    np.testing.assert_allclose(drives.position, TRAJECTORY.joint_position[-1])
    assert np.abs(np.diff(drives.positions, axis=0)).max() * RIG.rate < RIG.limits.speed


def asked_to_stop(*cycles: int) -> tuple[PerfectDrives, Stream, Rows]:
    """A run that is asked to stop in these cycles."""
    stop = StopRequest()

    def interfere(drives: PerfectDrives, cycle: int, sample: Sample) -> Sample:
        if cycle in cycles:
            stop.ask("stopped by the operator (SIGINT)")
        return sample

    drives = PerfectDrives(interfere)
    return drives, *stream(drives, stop=stop)


def test_stop_request_ramps_down_along_the_path() -> None:
    drives, run, _ = asked_to_stop(400)
    with pytest.raises(RunFailed, match="stopped by the operator"):
        run.run(TRAJECTORY)
    assert drives.stands_disabled()
    path = np.array(drives.positions[398:])
    speed = np.linalg.norm(np.diff(path, axis=0), axis=1) * RIG.rate
    assert speed[0] > 0.1
    assert np.abs(np.diff(speed)).max() < 0.2 * speed[0]
    distances = np.abs(TRAJECTORY.joint_position - path[:, None]).max(axis=2).min(axis=1)
    assert distances.max() < 0.02, "every point of the ramp lies on the commanded path"


def test_second_stop_request_is_a_quick_stop() -> None:
    drives, run, _ = asked_to_stop(400, 405)
    with pytest.raises(RunFailed, match="twice: quick stop"):
        run.run(TRAJECTORY)
    assert drives.goals.index(Goal.STOPPED) == 405
    assert drives.stands_disabled()


def test_stop_request_before_power_never_enables_the_drives() -> None:
    drives, run, _ = asked_to_stop(1)
    with pytest.raises(RunFailed, match="SIGINT"):
        run.run(TRAJECTORY)
    assert Goal.ENABLED not in drives.goals
    assert drives.stands_disabled()


def _from(cycle: int, goal: Goal | None = Goal.ENABLED, **changes: Any) -> Interference:
    """Answers with these changes from a cycle on, while this goal is pursued; None: whatever the goal."""

    def interfere(drives: PerfectDrives, now: int, sample: Sample) -> Sample:
        return replace(sample, **changes) if now >= cycle and goal in (None, drives.goal) else sample

    return interfere


@pytest.mark.parametrize(
    ("interfere", "reason"),
    [
        (_from(300, trouble="joint 2 (node 2): drive fault, continuous over-current (0x2310)"), "over-current"),
        (_from(300, position=(9.0, 0.0, 0.0)), "joint 1: position jump"),
        (_from(300, position=(math.nan,) * 3, missing=3), "joint 1: no answer for 50 ms"),
        (_from(300, power=(Power.ON, Power.ON, Power.OFF)), "joint 3: the drive left operation by itself"),
        (_from(2, power=(Power.ON, Power.OFF, Power.ON)), r"not enabled within 3 s: joint 2 \(off\)"),
    ],
)
def test_motion_fault_ends_in_a_quick_stop_of_the_drives(interfere: Interference, reason: str) -> None:
    drives = PerfectDrives(interfere)
    run, rows = stream(drives)
    with pytest.raises(RunFailed, match=reason):
        run.run(TRAJECTORY)
    assert drives.stands_disabled()
    assert Goal.ENABLED not in drives.goals[drives.goals.index(Goal.STOPPED) :]
    assert len(rows.rows) == len(drives.goals)


def test_what_the_drives_say_of_a_fault_afterwards_belongs_to_the_reason() -> None:
    drives = PerfectDrives(_from(300, trouble="joint 2 (node 2): drive fault without EMCY"))
    drives.details = "603F:00 says 0x2310"
    with pytest.raises(RunFailed, match=r"drive fault without EMCY; 603F:00 says 0x2310$"):
        stream(drives)[0].run(TRAJECTORY)


def test_joint_outside_its_range_is_never_enabled() -> None:
    drives = PerfectDrives()
    drives.position = np.array([0.3, 2.5, 0.3])
    with pytest.raises(RunFailed, match=r"joint 2 stands at 2\.500 rad"):
        stream(drives)[0].run(TRAJECTORY)
    assert Goal.ENABLED not in drives.goals


def test_full_disk_ends_in_an_orderly_stop() -> None:
    def interfere(drives: PerfectDrives, cycle: int, sample: Sample) -> Sample:
        rows.error = RunFailed("disk full") if cycle >= 300 else None
        return sample

    drives = PerfectDrives(interfere)
    run, rows = stream(drives)
    with pytest.raises(RunFailed, match="disk full"):
        run.run(TRAJECTORY)
    assert drives.goals.index(Goal.STOPPED) > 300 + 0.3 * RIG.rate
    assert drives.stands_disabled()


def test_lost_bus_reports_that_no_drive_confirmed() -> None:
    def interfere(drives: PerfectDrives, cycle: int, sample: Sample) -> Sample:
        if cycle >= 300:
            raise RunFailed("the CAN bus is lost: no such device")
        return sample

    run, _ = stream(PerfectDrives(interfere))
    with pytest.raises(RunFailed, match=r"the CAN bus is lost.*NOT CONFIRMED DISABLED: joint 1, joint 2, joint 3"):
        run.run(TRAJECTORY)


OFF_BUT_ONE = (Power.OFF, Power.ON, Power.OFF)


def test_failure_without_a_word_is_a_failure_all_the_same() -> None:
    def interfere(drives: PerfectDrives, cycle: int, sample: Sample) -> Sample:
        if cycle == 300:
            raise RunFailed("")
        return sample

    with pytest.raises(RunFailed):
        stream(PerfectDrives(interfere))[0].run(TRAJECTORY)


@pytest.mark.parametrize("found", [(Power.OFF,) * 3, OFF_BUT_ONE])
def test_error_of_the_program_ends_in_disabled_drives_and_hides_no_drive_that_is_on(found: tuple[Power, ...]) -> None:
    def interfere(drives: PerfectDrives, cycle: int, sample: Sample) -> Sample:
        if cycle >= 300:
            raise ZeroDivisionError("in the middle of a motion")
        return sample

    drives = PerfectDrives(interfere)
    drives.found_by_power_off = found
    expected = ZeroDivisionError if found[1] is Power.OFF else RunFailed
    with pytest.raises(expected, match=r"in the middle of a motion('\); NOT CONFIRMED DISABLED: joint 2)?"):
        stream(drives)[0].run(TRAJECTORY)
    assert drives.powered_off


@pytest.mark.parametrize("goal", [Goal.STOPPED, Goal.DISABLED])
def test_drive_that_stays_enabled_is_named(goal: Goal) -> None:
    drives = PerfectDrives(_from(300, goal, power=OFF_BUT_ONE))
    drives.found_by_power_off = OFF_BUT_ONE
    run, _ = stream(drives)
    if goal is Goal.STOPPED:  # it is off at last
        run.run(TRAJECTORY)
        return
    with pytest.raises(RunFailed, match="NOT CONFIRMED DISABLED: joint 2"):
        run.run(TRAJECTORY)
    assert drives.powered_off


def test_drive_disabled_by_the_fallback_is_confirmed() -> None:
    drives = PerfectDrives(_from(300, None, position=(math.nan,) * 3, missing=3))
    drives.found_by_power_off = (Power.OFF,) * 3
    run, rows = stream(drives)
    with pytest.raises(RunFailed, match="no answer") as failure:
        run.run(TRAJECTORY)
    assert "NOT CONFIRMED" not in str(failure.value)
    assert drives.powered_off
    assert len(rows.rows) < 300 + 2 * RIG.rate


class StallingClock(LockstepClock):
    """Clock of a host that misses some periods once."""

    def __init__(self, rate: float, periods: float) -> None:
        super().__init__(rate)
        self._stall = periods / rate

    def overdue(self, index: int) -> float:
        return self._stall if index == 400 else 0.0


def ahead(drives: PerfectDrives, count: int, sample: Sample) -> Sample:
    """The kernel sends every SYNC; the program misses four of them before the 401st exchange."""
    return replace(sample, sync=count - 1 + (4 if count > 400 else 0))


@pytest.mark.parametrize("late", ["host", "kernel"])
def test_missed_cycles_are_gaps_and_the_motion_does_not_jump(late: str) -> None:
    drives = PerfectDrives(ahead if late == "kernel" else None)
    run, rows = stream(drives, clock=StallingClock(RIG.rate, 4.0 if late == "host" else 0.0))
    run.run(TRAJECTORY)
    assert [row[2] for row in rows.rows] == list(range(len(rows.rows)))
    gaps = [row for row in rows.rows if math.isnan(row[7].position[0])]
    assert [row[2] for row in gaps] == [400, 401, 402, 403]
    assert all(np.isnan(row[5]).all() and row[7].missing == 3 for row in gaps)
    np.testing.assert_array_equal([row[5] for row in rows.rows if row[6] is not None], TRAJECTORY.joint_position)
    assert rows.events == [f"host {40.0 if late == 'host' else 0.0} ms late, 4 missed"]
    assert (rows.progress.missed, rows.progress.lost) == (4, 0)


def test_long_host_stall_ends_the_run_along_the_path() -> None:
    drives = PerfectDrives()
    run, _ = stream(drives, clock=StallingClock(RIG.rate, 7.4))
    with pytest.raises(RunFailed, match="the host came 74 ms late, 50 ms allowed"):
        run.run(TRAJECTORY)
    assert drives.stands_disabled()
    assert drives.goals.index(Goal.STOPPED) > 400 + 0.3 * RIG.rate
