"""Run of a trajectory: enable, approach, stream, come to rest, disable. The drives end disabled in every case.

If the motion itself is healthy (operator's stop, full disk), the drives ramp down along the commanded path.
If it is not (fault, following error, no answers), every drive stops at once on its own quick-stop ramp.
"""

import gc
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from daq.cycle.exchange import RecordedExchange, RunParts
from daq.cycle.supervisor import Supervisor
from daq.feedforward.segments import Segment, segments
from daq.feedforward.source import PlannedTorque
from drivers.protocol import Goal, Power, Sample, Setpoint
from recordings.errors import RunFailed
from recordings.interpolation import interpolate_columns
from recordings.recording import Floats
from trajectories import Trajectory, approach

_POWER_TIMEOUT = 3.0
"""Longest time that the drives may take to answer or to disable [s]."""
_NO_REACTION_TIMEOUT = 0.2
"""Longest time without answers, or without a reaction of an enabled drive, while disabling [s]."""
_RAMP_TIME = 0.4
"""Duration of an orderly stop along the path [s]."""
_PAUSE = 0.02
"""Pause between two looks at a computation in simulated time [s]."""
_SWITCH_INTERVAL = 1e-4
"""Longest time that another thread may hold the interpreter while the cycle waits for it [s]."""

STOPPED_TO_SEE = "stopped to measure the quick stop"
"""Reason of a stop that was asked for in the request."""


class MotionFault(Exception):
    """Fault of the motion: all drives must stop at once."""


class StopRequested(Exception):
    """Request to end a healthy motion."""


class Stream:
    """Run of one trajectory on configured drives."""

    def __init__(self, parts: RunParts) -> None:
        self._parts = parts
        self._exchange = RecordedExchange(parts)
        self._supervisor = Supervisor(parts.rig)
        self._target: Floats | None = None
        self._offset: Floats | None = None if parts.feedforward is None else np.zeros(parts.rig.dof)

    def run(self, trajectory: Trajectory, plan: Callable[[Floats], Trajectory] | None = None) -> None:
        """Stream `trajectory`, or what `plan` makes for the pose in which the robot stands; return when it is
        complete and the drives are disabled.

        Raises:
            BadInput: there is no such motion from this pose; the drives were not enabled.
            RunFailed: the motion was not completed; the drives are disabled (or the message names the others).
        """
        with self._supervised():
            position = self._wait_for_answers()
            if plan is not None:
                trajectory = plan(position)
            torque = self._plan_torque(position, trajectory)
            start = self._enable()
            for segment in segments(self._parts.rig, start, trajectory, torque):
                self._follow(segment)

    @contextmanager
    def _supervised(self) -> Iterator[None]:
        """Disable the drives at the end of the block in every case.

        Raises:
            RunFailed: the block was not completed; the drives are disabled (or the message names the others).
        """
        with _quiet_interpreter():
            reason, other = None, None
            try:
                yield
            except (MotionFault, StopRequested, RunFailed) as stop:
                reason = str(stop)
            except BaseException as error:  # there is no such motion, or this program is wrong: power comes first
                other = error
            left_on = self._disable()
            if reason is not None and (details := self._parts.amplifiers.fault_details()):
                reason = f"{reason}; {details}"
            if left_on:
                cause = reason or (repr(other) if other else "end of the motion")
                reason = f"{cause}; NOT CONFIRMED DISABLED: {left_on}. Cut the power by hand"
            if reason is not None:
                raise RunFailed(reason) from other
            if other is not None:
                raise other

    def dry_run(self, trajectory: Trajectory) -> Floats:
        """Exchange cycles for a second without power; plan and encode the approach and the trajectory.

        Returns the joint positions (dof,) [rad].

        Raises:
            RunFailed: a drive does not answer, reports a fault, or its position is outside the joint limits.
        """
        with _quiet_interpreter():
            try:
                position = self._wait_for_answers()
                for _ in range(self._parts.cycle_count(1.0)):
                    self._without_target()
                torque = self._plan_torque(position, trajectory)
            except (MotionFault, StopRequested) as stop:
                raise RunFailed(str(stop)) from None
        for segment in segments(self._parts.rig, position, trajectory, torque):
            self._parts.amplifiers.encode(segment.path, segment.torque)
        return position

    # Phases

    def _wait_for_answers(self) -> Floats:
        for _ in range(self._parts.cycle_count(_POWER_TIMEOUT)):
            self._raise_stop()
            sample = self._without_target()
            if not sample.missing:
                self._raise_fault(self._supervisor.standstill(sample.position))
                return np.array(sample.position)
        raise MotionFault("no complete answer from all drives; check the bus")

    def _without_target(self) -> Sample:
        """Exchange a cycle without a motion, in which the drives must answer and have no fault."""
        sample = self._exchange.without_target()
        self._raise_fault(self._supervisor.drives(sample))
        return sample

    def _plan_torque(self, position: Floats, trajectory: Trajectory) -> PlannedTorque | None:
        """Compute the torque to feed forward, while the drives are kept answering."""
        if self._parts.feedforward is None:
            return None
        self._parts.progress.phase = "torque"
        path = approach(position, trajectory.joint_position[0], self._parts.rig.limits, self._parts.rig.rate)
        return self._parts.feedforward.plan(self._exchange.time, path, trajectory, self._idle)

    def _idle(self) -> None:
        self._raise_stop()
        if self._parts.clock.simulated:
            # The number of cycles must not depend on how long the computation takes.
            time.sleep(_PAUSE)
        else:
            self._without_target()

    def _enable(self) -> Floats:
        """Switch power on; returns the position at which the drives hold (dof,) [rad]."""
        self._parts.progress.phase = "enable"
        self._raise_stop()  # of the planning, which may have taken long
        self._parts.amplifiers.goal = Goal.ENABLED
        timeout = self._parts.rig.enable_timeout
        for _ in range(self._parts.cycle_count(timeout)):
            self._raise_stop()
            sample = self._without_target()
            if all(power is Power.ON for power in sample.power) and not sample.missing:
                self._target = np.array(sample.position)
                return self._target
        late = [f"joint {j + 1} ({power.value})" for j, power in enumerate(sample.power) if power is not Power.ON]
        raise MotionFault(
            f"not enabled within {timeout:g} s: {', '.join(late)}; check enable inputs and the "
            "supply, or raise enable_timeout in the rig file"
        )

    def _follow(self, segment: Segment) -> None:
        """Stream the targets of a segment; with a trajectory, record its platform path and repetitions too."""
        progress, path, torque, trajectory = self._parts.progress, segment.path, segment.torque, segment.trajectory
        progress.phase, progress.done, progress.total = segment.phase, 0, len(path)
        setpoints = self._parts.amplifiers.encode(path, torque)
        for i, setpoint in enumerate(setpoints):
            repeat = -1 if trajectory is None else int(trajectory.repeat[i])
            platform = None if trajectory is None else trajectory.platform[i]
            self._move(setpoint, path[i], None if torque is None else torque[i], repeat, platform, segment.is_probe)
            if trajectory is not None and i == self._parts.stop_at:
                raise MotionFault(STOPPED_TO_SEE)
            progress.done = i + 1
            progress.following_error = self._supervisor.worst_following_error
            if self._parts.stop.count or self._parts.recorder.error:
                self._ramp_down(path[i:], None if torque is None else torque[i:])
                raise StopRequested(str(self._parts.recorder.error or self._parts.stop.reason))
        if segment.is_probe:
            self._raise_fault(self._supervisor.after_silence(self._supervisor.offsets.judge_answers()))

    def _ramp_down(self, ahead: Floats, torque: Floats | None) -> None:
        """Come to rest along the path ahead: the pace along the path and the offset fall smoothly to 0."""
        self._parts.progress.phase = "stop"
        count = self._parts.cycle_count(_RAMP_TIME)
        s = np.arange(1, count + 1) / count
        # Integral of the pace 1 - 3 s^2 + 2 s^3: rows of the path passed after each cycle.
        rows = np.minimum(count * (s - s**3 + s**4 / 2), len(ahead) - 1)
        index, pace = np.arange(len(ahead)), (1 - 3 * s**2 + 2 * s**3)[:, None]
        path = interpolate_columns(rows, index, ahead)
        offsets = None if torque is None else interpolate_columns(rows, index, torque) * pace
        for i, setpoint in enumerate(self._parts.amplifiers.encode(path, offsets)):
            if self._parts.stop.count > 1:
                raise MotionFault(f"{self._parts.stop.reason}, twice: quick stop")
            self._move(setpoint, path[i], None if offsets is None else offsets[i])

    def _move(
        self,
        setpoint: Setpoint,
        target: Floats,
        offset: Floats | None,
        repeat: int = -1,
        platform: Floats | None = None,
        is_probe: bool = False,
    ) -> None:
        """Send the target of one cycle; supervise the answers, which show how the previous target was reached."""
        assert self._target is not None
        supervisor, reached, missed = self._supervisor, self._target, self._parts.progress.missed
        sample = self._exchange.run(setpoint, target, repeat, platform, offset)
        supervisor.note_missed(self._parts.progress.missed - missed)
        fault = supervisor.drives(sample) or supervisor.motion(sample, reached, None if is_probe else self._offset)
        self._raise_fault(fault)
        if is_probe and self._offset is not None:
            supervisor.offsets.note_answer(sample, self._offset)
        self._target, self._offset = target, offset

    def _disable(self) -> str:
        """Command a quick stop, then power off; return the joints that did not confirm."""
        self._parts.progress.phase = "disable"
        try:
            # A drive at standstill ends the quick stop at once, so the quick stop suits all drives.
            for goal in (Goal.STOPPED, Goal.DISABLED):
                power = self._wait_off(goal)
        except Exception as error:  # whatever the cycle cannot do any more, SDOs may
            self._parts.recorder.event(self._parts.clock.now(), "error", "bus", str(error))
            power = (Power.UNKNOWN,)
        if not _all_off(power):
            power = self._parts.amplifiers.power_off()
        return ", ".join(f"joint {j + 1}" for j, p in enumerate(power) if not _all_off([p]))

    def _wait_off(self, goal: Goal) -> tuple[Power, ...]:
        """Wait until all drives are off, or one does not answer or react for long; return the power states."""
        self._parts.amplifiers.goal = goal
        patience = self._parts.cycle_count(_NO_REACTION_TIMEOUT)
        unanswered = unresponsive = 0
        for _ in range(self._parts.cycle_count(_POWER_TIMEOUT)):
            sample = self._exchange.without_target()
            unanswered = unanswered + 1 if sample.missing else 0
            unresponsive = unresponsive + 1 if Power.ON in sample.power else 0
            if (not unanswered and _all_off(sample.power)) or max(unanswered, unresponsive) >= patience:
                break
        return sample.power if not unanswered else (Power.UNKNOWN,)

    def _raise_stop(self) -> None:
        if self._parts.stop.count:
            raise StopRequested(self._parts.stop.reason)

    def _raise_fault(self, reason: str | None) -> None:
        if reason is not None:
            raise MotionFault(reason)


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
