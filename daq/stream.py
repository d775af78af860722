"""Run of a trajectory: enable, approach, stream, come to rest, disable. The drives end disabled in every case.

If the motion itself is healthy (operator's stop, full disk), the drives ramp down along the commanded path.
If it is not (fault, following error, no answers), every drive stops at once on its own quick-stop ramp.
"""

import gc
import math
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from daq.clock import Clock
from daq.recorder import NullRecorder, Recorder
from daq.stopping import StopRequest
from daq.supervisor import Supervisor
from daq.watched import CycleProgress
from drivers.protocol import Amplifiers, Goal, Power, Sample, Setpoint
from recordings.errors import RunFailed
from recordings.recording import Floats
from recordings.rig import Rig
from trajectories import Trajectory, approach

_POWER_TIMEOUT = 3.0
"""Longest time that the drives may take to answer or to disable [s]."""
_NO_REACTION_TIMEOUT = 0.2
"""Longest time without answers, or without a reaction of an enabled drive, while disabling [s]."""
_RAMP_TIME = 0.4
"""Duration of an orderly stop along the path [s]."""
_SWITCH_INTERVAL = 1e-4
"""Longest time that another thread may hold the interpreter while the cycle waits for it [s]."""


class MotionFault(Exception):
    """Fault of the motion: all drives must stop at once."""


class StopRequested(Exception):
    """Request to end a healthy motion."""


class Stream:
    """Run of one trajectory on configured drives."""

    def __init__(
        self,
        rig: Rig,
        amplifiers: Amplifiers,
        clock: Clock,
        recorder: Recorder | NullRecorder,
        stop: StopRequest,
        progress: CycleProgress,
    ) -> None:
        self._rig = rig
        self._amplifiers = amplifiers
        self._clock = clock
        self._recorder = recorder
        self._stop = stop
        self._progress = progress
        self._supervisor = Supervisor(rig)
        self._index = 0
        self._target: Floats | None = None
        self._no_command: Floats = np.full(rig.dof, math.nan)
        self._no_answer = Sample(
            position=(math.nan,) * rig.dof,
            voltage=(math.nan,) * rig.dof,
            statusword=(0,) * rig.dof,
            error_code=(0,) * rig.dof,
            power=(Power.UNKNOWN,) * rig.dof,
            missing=rig.dof,
            trouble=None,
        )

    def run(self, trajectory: Trajectory) -> None:
        """Stream `trajectory`; return when it is complete and the drives are disabled.

        Raises:
            RunFailed: the motion was not completed; the drives are disabled (or the message names the others).
        """
        with _quiet_interpreter():
            reason = None
            try:
                self._wait_for_answers()
                self._enable()
                self._approach(trajectory.joint_position[0])
                self._follow("stream", trajectory.joint_position, trajectory)
            except (MotionFault, StopRequested, RunFailed) as stop:
                reason = str(stop)
            finally:
                left_on = self._disable()
            if left_on:
                reason = f"{reason or 'end of the motion'}; NOT CONFIRMED DISABLED: {left_on}. Cut the power by hand"
            if reason is not None:
                raise RunFailed(reason)

    def dry_run(self, trajectory: Trajectory) -> Floats:
        """Exchange cycles for a second without power; plan and encode the approach and the trajectory.

        Returns the joint positions (dof,) [rad].

        Raises:
            RunFailed: a drive does not answer, reports a fault, or its position is outside the joint limits.
        """
        with _quiet_interpreter():
            try:
                position = self._wait_for_answers()
                for _ in range(self._cycle_count(1.0)):
                    self._raise_fault(self._supervisor.drives(self._cycle(None, self._no_command)))
            except (MotionFault, StopRequested) as stop:
                raise RunFailed(str(stop)) from None
        self._amplifiers.encode(approach(position, trajectory.joint_position[0], self._rig.limits, self._rig.rate))
        self._amplifiers.encode(trajectory.joint_position)
        return position

    # Phases

    def _wait_for_answers(self) -> Floats:
        for _ in range(self._cycle_count(_POWER_TIMEOUT)):
            if self._stop.count:
                raise StopRequested(self._stop.reason)
            sample = self._cycle(None, self._no_command)
            self._raise_fault(self._supervisor.drives(sample))
            if not sample.missing:
                self._raise_fault(self._supervisor.standstill(sample.position))
                return np.array(sample.position)
        raise MotionFault("no complete answer from all drives; check the bus")

    def _enable(self) -> None:
        self._progress.phase = "enable"
        self._amplifiers.goal = Goal.ENABLED
        for _ in range(self._cycle_count(self._rig.enable_timeout)):
            sample = self._cycle(None, self._no_command)
            self._raise_fault(self._supervisor.drives(sample))
            if all(power is Power.ON for power in sample.power) and not sample.missing:
                self._target = np.array(sample.position)
                return
        late = [f"joint {j + 1} ({power.value})" for j, power in enumerate(sample.power) if power is not Power.ON]
        raise MotionFault(
            f"not enabled within {self._rig.enable_timeout:g} s: {', '.join(late)}; check enable inputs and the "
            "supply, or raise enable_timeout in the rig file"
        )

    def _approach(self, goal: Floats) -> None:
        assert self._target is not None
        path = approach(self._target, goal, self._rig.limits, self._rig.rate)
        self._follow("approach", path, None)

    def _follow(self, phase: str, path: Floats, trajectory: Trajectory | None) -> None:
        """Stream joint targets (m, dof); with a trajectory, record its platform path and repetitions too."""
        progress = self._progress
        progress.phase, progress.done, progress.total = phase, 0, len(path)
        setpoints = self._amplifiers.encode(path)
        for i, setpoint in enumerate(setpoints):
            repeat = -1 if trajectory is None else int(trajectory.repeat[i])
            platform = None if trajectory is None else trajectory.platform[i]
            self._move(setpoint, path[i], repeat, platform)
            progress.done = i + 1
            progress.following_error = self._supervisor.worst_following_error
            if self._stop.count or self._recorder.error:
                self._ramp_down(path[i:])
                raise StopRequested(str(self._recorder.error or self._stop.reason))

    def _ramp_down(self, ahead: Floats) -> None:
        """Come to rest along the path ahead; the pace along the path falls smoothly from 1 to 0."""
        self._progress.phase = "stop"
        count = self._cycle_count(_RAMP_TIME)
        s = np.arange(1, count + 1) / count
        # Integral of the pace 1 - 3 s^2 + 2 s^3: rows of the path passed after each cycle.
        rows = np.minimum(count * (s - s**3 + s**4 / 2), len(ahead) - 1)
        path = np.column_stack([np.interp(rows, np.arange(len(ahead)), column) for column in ahead.T])
        for target, setpoint in zip(path, self._amplifiers.encode(path), strict=True):
            if self._stop.count > 1:
                raise MotionFault(f"{self._stop.reason}, twice: quick stop")
            self._move(setpoint, target)

    def _move(self, setpoint: Setpoint, target: Floats, repeat: int = -1, platform: Floats | None = None) -> None:
        """Send the target of one cycle; supervise the answers, which show how the previous target was reached."""
        assert self._target is not None
        sample = self._cycle(setpoint, target, repeat, platform)
        self._raise_fault(self._supervisor.drives(sample) or self._supervisor.motion(sample, self._target))
        self._target = target

    def _disable(self) -> str:
        """Command a quick stop, then power off; return the joints that did not confirm."""
        self._progress.phase = "disable"
        try:
            # A drive at standstill ends the quick stop at once, so the quick stop suits all drives.
            for goal in (Goal.STOPPED, Goal.DISABLED):
                power = self._wait_off(goal)
        except RunFailed as error:
            self._recorder.event(self._clock.now(), "error", "bus", str(error))
            power = (Power.UNKNOWN,)
        if not _all_off(power):
            power = self._amplifiers.power_off()
        return ", ".join(f"joint {j + 1}" for j, p in enumerate(power) if not _all_off([p]))

    def _wait_off(self, goal: Goal) -> tuple[Power, ...]:
        """Wait until all drives are off, or one does not answer or react for long; return the power states."""
        self._amplifiers.goal = goal
        unanswered = unresponsive = 0
        for _ in range(self._cycle_count(_POWER_TIMEOUT)):
            sample = self._cycle(None, self._no_command)
            unanswered = unanswered + 1 if sample.missing else 0
            unresponsive = unresponsive + 1 if Power.ON in sample.power else 0
            if (not unanswered and _all_off(sample.power)) or max(unanswered, unresponsive) >= self._cycle_count(
                _NO_REACTION_TIMEOUT
            ):
                break
        return sample.power if not unanswered else (Power.UNKNOWN,)

    # One cycle

    def _cycle(
        self, setpoint: Setpoint | None, command: Floats, repeat: int = -1, platform: Floats | None = None
    ) -> Sample:
        clock, index = self._clock, self._skip_missed()
        lateness = clock.wait(index)
        sample = self._amplifiers.exchange(setpoint, max(clock.answer_timeout - lateness, 0.2 * clock.answer_timeout))
        if sample.sync is not None and sample.sync > index:
            self._record_missed(index, sample.sync, lateness)
            index = sample.sync
        self._recorder.cycle(clock.stamp(index), clock.now(), index, repeat, lateness, command, platform, sample)
        self._index = index + 1
        progress = self._progress
        progress.cycles += 1
        progress.lost += sample.missing
        progress.lateness.append(lateness)
        progress.recent.append((index, command, sample))
        return sample

    def _skip_missed(self) -> int:
        """Skip missed cycles and return the next SYNC index.

        If the host is whole periods late, their SYNCs were never sent: they are recorded as gaps, and the motion
        continues from its last target without a jump.
        """
        clock = self._clock
        lateness = clock.overdue(self._index)
        missed = int(lateness * self._rig.rate)
        if missed:
            self._record_missed(self._index, self._index + missed, lateness)
        allowed = self._rig.limits.host_stall
        if lateness > allowed and not self._stop.count:
            self._stop.ask(
                f"the host came {lateness * 1e3:.0f} ms late, {allowed * 1e3:g} ms allowed (limits.host_stall); "
                "close other programs"
            )
        return self._index + missed

    def _record_missed(self, first: int, end: int, lateness: float) -> None:
        clock, missed = self._clock, end - first
        for index in range(first, end):
            self._recorder.cycle(
                clock.stamp(index), clock.now(), index, -1, lateness, self._no_command, None, self._no_answer
            )
        self._progress.missed += missed
        self._recorder.event(clock.now(), "warning", "cycle", f"host {lateness * 1e3:.1f} ms late, {missed} missed")

    def _raise_fault(self, reason: str | None) -> None:
        if reason is not None:
            raise MotionFault(reason)

    def _cycle_count(self, duration: float) -> int:
        return max(1, round(duration * self._rig.rate))


def _all_off(power: Sequence[Power]) -> bool:
    return all(p in (Power.OFF, Power.FAULT) for p in power)


@contextmanager
def _quiet_interpreter() -> Iterator[None]:
    """Switch garbage collection off and shorten the switch interval of threads during the block."""
    interval = sys.getswitchinterval()
    gc.collect()
    gc.disable()
    sys.setswitchinterval(_SWITCH_INTERVAL)
    try:
        yield
    finally:
        sys.setswitchinterval(interval)
        gc.enable()
