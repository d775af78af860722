"""The exchange with the drives, cycle after cycle; every SYNC is recorded, and so is each that was missed."""

import math
from dataclasses import dataclass

import numpy as np

from daq.cycle.clock import Clock
from daq.cycle.progress import CycleProgress
from daq.cycle.recorder import NullRecorder, Recorder
from daq.cycle.stopping import StopRequest
from daq.feedforward.planning import Feedforward
from drivers.protocol import Amplifiers, Power, Sample, Setpoint
from recordings.recording import Floats
from recordings.rig import Rig


@dataclass
class RunParts:
    """What the cycles of one run share."""

    rig: Rig
    amplifiers: Amplifiers
    clock: Clock
    recorder: Recorder | NullRecorder
    stop: StopRequest
    progress: CycleProgress
    feedforward: Feedforward | None = None
    """With one, every cycle has a torque offset, 0 where none is given."""
    stop_at: int | None = None
    """Row of the motion at which all drives are stopped at once, to see how; None: the motion is completed."""

    def cycle_count(self, duration: float) -> int:
        """Number of cycles in a `duration` [s], at least one."""
        return max(1, round(duration * self.rig.rate))


class RecordedExchange:
    """The cycles of a run: `index` is the SYNC of the next one."""

    def __init__(self, parts: RunParts) -> None:
        self.index = 0
        self._parts = parts
        dof = parts.rig.dof
        self._no_offset: Floats | None = None if parts.feedforward is None else np.zeros(dof)
        self._no_command: Floats = np.full(dof, math.nan)
        self._no_answer = Sample(
            position=(math.nan,) * dof,
            voltage=(math.nan,) * dof,
            statusword=(0,) * dof,
            error_code=(0,) * dof,
            power=(Power.UNKNOWN,) * dof,
            missing=dof,
            trouble=None,
        )

    @property
    def time(self) -> float:
        """Time of the next SYNC, after that of the first [s]."""
        return self.index / self._parts.rig.rate

    def without_target(self) -> Sample:
        """Exchange one cycle in which no drive gets a target."""
        return self.run(None, self._no_command)

    def run(
        self,
        setpoint: Setpoint | None,
        command: Floats,
        repeat: int = -1,
        platform: Floats | None = None,
        offset: Floats | None = None,
    ) -> Sample:
        """Wait for the next cycle, send `setpoint`, and record it and the answers.

        command: joint targets (dof,) [rad]; repeat: repetition of the motion, -1 outside; platform: its reference
        (3,) [m]; offset: torque (dof,) that the drives add [N m].
        """
        parts, clock, index = self._parts, self._parts.clock, self._skip_missed()
        lateness = clock.wait(index)
        timeout = max(clock.answer_timeout - lateness, 0.2 * clock.answer_timeout)
        sample = parts.amplifiers.exchange(setpoint, timeout)
        clock.note_answers(sample.missing)
        if sample.sync is not None and sample.sync > index:
            self._record_missed(index, sample.sync, lateness)
            index = sample.sync
        offset = self._no_offset if offset is None else offset
        parts.recorder.cycle(
            clock.stamp(index), clock.now(), index, repeat, lateness, command, platform, sample, offset
        )
        self.index = index + 1
        progress = parts.progress
        progress.cycles += 1
        progress.lost += sample.missing
        if not sample.missing:
            progress.pose = sample.position
        progress.lateness.append(lateness)
        progress.recent.append((index, command, sample))
        return sample

    def _skip_missed(self) -> int:
        """Skip missed cycles and return the next SYNC index.

        If the host is whole periods late, their SYNCs were never sent: they are recorded as gaps, and the motion
        continues from its last target without a jump.
        """
        rig, stop = self._parts.rig, self._parts.stop
        lateness = self._parts.clock.overdue(self.index)
        missed = int(lateness * rig.rate)
        if missed:
            self._record_missed(self.index, self.index + missed, lateness)
        allowed = rig.limits.host_stall
        if lateness > allowed and not stop.count:
            stop.ask(
                f"the host came {lateness * 1e3:.0f} ms late, {allowed * 1e3:g} ms allowed (limits.host_stall); "
                "close other programs"
            )
        return self.index + missed

    def _record_missed(self, first: int, end: int, lateness: float) -> None:
        clock, recorder, missed = self._parts.clock, self._parts.recorder, end - first
        for index in range(first, end):
            recorder.cycle(
                clock.stamp(index), clock.now(), index, -1, lateness, self._no_command, None, self._no_answer
            )
        self._parts.progress.missed += missed
        recorder.event(clock.now(), "warning", "cycle", f"host {lateness * 1e3:.1f} ms late, {missed} missed")
