"""The exchange with the drives, cycle after cycle; every SYNC is recorded, and so is each that was missed."""

import math

import numpy as np

from daq.cycle.clock import Clock
from daq.cycle.progress import CycleProgress
from daq.cycle.recorder import NullRecorder, Recorder
from daq.cycle.stopping import StopRequest
from drivers.protocol import Amplifiers, Power, Sample, Setpoint
from recordings.recording import Floats
from recordings.rig import Rig


class RecordedExchange:
    """The cycles of a run: `index` is the SYNC of the next one."""

    def __init__(
        self,
        rig: Rig,
        amplifiers: Amplifiers,
        clock: Clock,
        recorder: Recorder | NullRecorder,
        stop: StopRequest,
        progress: CycleProgress,
        *,
        feedforward: bool,
    ) -> None:
        """`feedforward`: every cycle has a torque offset, 0 where none is given."""
        self.clock = clock
        self.index = 0
        self._rig = rig
        self._amplifiers = amplifiers
        self._recorder = recorder
        self._stop = stop
        self._progress = progress
        self._no_offset: Floats | None = np.zeros(rig.dof) if feedforward else None
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

    @property
    def time(self) -> float:
        """Time of the next SYNC, after that of the first [s]."""
        return self.index / self._rig.rate

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
        clock, index = self.clock, self._skip_missed()
        lateness = clock.wait(index)
        sample = self._amplifiers.exchange(setpoint, max(clock.answer_timeout - lateness, 0.2 * clock.answer_timeout))
        if sample.sync is not None and sample.sync > index:
            self._record_missed(index, sample.sync, lateness)
            index = sample.sync
        offset = self._no_offset if offset is None else offset
        self._recorder.cycle(
            clock.stamp(index), clock.now(), index, repeat, lateness, command, platform, sample, offset
        )
        self.index = index + 1
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
        lateness = self.clock.overdue(self.index)
        missed = int(lateness * self._rig.rate)
        if missed:
            self._record_missed(self.index, self.index + missed, lateness)
        allowed = self._rig.limits.host_stall
        if lateness > allowed and not self._stop.count:
            self._stop.ask(
                f"the host came {lateness * 1e3:.0f} ms late, {allowed * 1e3:g} ms allowed (limits.host_stall); "
                "close other programs"
            )
        return self.index + missed

    def _record_missed(self, first: int, end: int, lateness: float) -> None:
        clock, missed = self.clock, end - first
        for index in range(first, end):
            self._recorder.cycle(
                clock.stamp(index), clock.now(), index, -1, lateness, self._no_command, None, self._no_answer
            )
        self._progress.missed += missed
        self._recorder.event(clock.now(), "warning", "cycle", f"host {lateness * 1e3:.1f} ms late, {missed} missed")
