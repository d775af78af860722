"""Runs with a feed-forward on drives whose torque is what the motion takes: the offset is 0 whenever the drives are
not driven along the path."""

from collections.abc import Sequence
from dataclasses import replace
from threading import Event, Timer
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from daq.cycle.clock import LockstepClock
from daq.cycle.exchange import RunParts
from daq.cycle.stopping import StopRequest
from daq.cycle.stream import Stream
from daq.feedforward.planning import Feedforward
from daq.feedforward.segments import lead_in
from drivers.protocol import Goal, Power, Sample
from recordings.errors import RunFailed
from recordings.rig import simulated_rig
from tests.daq.cycle.test_stream import PerfectDrives, Rows
from tests.daq.feedforward.given import GivenTorque
from trajectories import load
from trajectories.checks import torque_estimate

RIG = simulated_rig().at_rate(100.0).with_torque_offset()
TRAJECTORY = load("fig5a", RIG, cycles=1)
TORQUE = torque_estimate(TRAJECTORY, RIG)


class Driven(PerfectDrives):
    """Drives that need 7 N m at rest and TORQUE along the path, and follow a share of the offset."""

    def __init__(self, share: float = 1.0, interfere: Any = None) -> None:
        super().__init__(interfere)
        self.share = share
        self.offsets: list[NDArray[np.float64]] = []
        self._offset = np.zeros(3)

    def encode(self, targets: NDArray[np.float64], torque: NDArray[np.float64] | None = None) -> Sequence[Any]:
        return list(zip(targets, np.zeros_like(targets) if torque is None else torque, strict=True))

    def exchange(self, setpoint: Any, timeout: float) -> Sample:
        target, offset = (None, np.zeros(3)) if setpoint is None else setpoint
        row = int(np.abs(TRAJECTORY.joint_position - self.position).sum(axis=1).argmin())
        needed = TORQUE[row] if np.abs(self._offset).max() > 1.01 or len(self.goals) > 150 else np.full(3, 7.0)
        small = np.abs(self._offset).max() <= 1.01
        torque = needed + (self.share * self._offset if small else 0.0)
        sample = replace(
            super().exchange(target, timeout),
            voltage=tuple((np.sign(torque) * np.sqrt(np.abs(torque))).tolist()),
        )
        self.offsets.append(offset)
        self._offset = offset if self.power is Power.ON else np.zeros(3)
        return sample


def run(
    drives: Driven,
    torque: NDArray[np.float64] = TORQUE,
    stop: StopRequest | None = None,
    computed_after: float = 0.05,
) -> Rows:
    """computed_after: time of the computation [s]; as a rule longer than the first look at it."""
    rows, ready = Rows(), Event()
    Timer(computed_after, ready.set).start()
    source = GivenTorque(torque, ready=ready)
    feedforward = Feedforward(source, RIG, frozenset(), lambda *line: None)
    clock, stop = LockstepClock(RIG.rate), stop or StopRequest()
    parts = RunParts(RIG, drives, clock, rows, stop, rows.progress, feedforward)  # type: ignore[arg-type]
    Stream(parts).run(TRAJECTORY)
    assert source.start == pytest.approx(1 / RIG.rate + lead_in(RIG)), "planned after the first answers"
    return rows


def test_offset_is_sent_along_the_path_and_zero_before_and_after() -> None:
    drives = Driven()
    rows = run(drives)
    offsets = np.array(drives.offsets)
    on = np.array([goal is Goal.ENABLED for goal in drives.goals])
    np.testing.assert_array_equal(offsets[~on], 0)
    assert np.abs(np.diff(offsets, axis=0))[np.abs(offsets[1:]).max(axis=1) > 1.01].max() < 2.0
    streamed = [k for k, row in enumerate(rows.rows) if row[6] is not None]
    np.testing.assert_allclose(offsets[streamed][1:], (TORQUE[1:] + TORQUE[:-1]) / 2)
    np.testing.assert_array_equal([row[8] for row in rows.rows], offsets)
    assert drives.stands_disabled()


@pytest.mark.parametrize("share", [0.0, -1.0])
def test_drive_that_does_not_follow_ends_the_run_before_it_gets_the_torque(share: float) -> None:
    drives = Driven(share)
    with pytest.raises(RunFailed, match="joint 1: the drive does not follow its torque offset"):
        run(drives)
    assert np.abs(drives.offsets).max() <= 1.0
    assert drives.stands_disabled()


@pytest.mark.parametrize("factor", [-1.0, 3.0])
def test_wrong_torque_ends_the_run_in_a_quick_stop_without_offset(factor: float) -> None:
    drives = Driven()
    with pytest.raises(RunFailed, match="works against the drive"):
        run(drives, factor * TORQUE)
    first = drives.goals.index(Goal.STOPPED)
    np.testing.assert_array_equal(drives.offsets[first:], 0)
    assert drives.stands_disabled()


def test_stop_request_lets_the_offset_fall_along_the_path() -> None:
    stop = StopRequest()

    def interfere(drives: PerfectDrives, cycle: int, sample: Sample) -> Sample:
        if cycle == 400:
            stop.ask("stopped by the operator (SIGINT)")
        return sample

    drives = Driven(interfere=interfere)
    with pytest.raises(RunFailed, match="SIGINT"):
        run(drives, stop=stop)
    ramp = np.array(drives.offsets[399 : drives.goals.index(Goal.STOPPED)])
    assert np.abs(ramp[0]).max() > 3.0
    np.testing.assert_allclose(ramp[-1], 0, atol=1e-9)
    assert np.abs(np.diff(ramp, axis=0)).max() < 1.0


@pytest.mark.parametrize("computed_after", [0.0, 0.2])
def test_stop_request_while_the_torque_is_computed_never_enables(computed_after: float) -> None:
    stop, drives = StopRequest(), Driven()

    def interfere(drives: PerfectDrives, cycle: int, sample: Sample) -> Sample:
        stop.ask("stopped by the operator (SIGTERM)")
        return sample

    drives._interfere = interfere
    with pytest.raises(RunFailed, match="SIGTERM"):
        run(drives, stop=stop, computed_after=computed_after)
    assert Goal.ENABLED not in drives.goals
