"""Safety checks of every cycle; the first violation ends the run.

Every check returns None, or the reason to stop with joint, value and limit.
"""

import math
from collections import deque
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from daq.feedforward.watch import OffsetWatch, measured_torque
from drivers.protocol import Power, Sample
from recordings.rig import Rig

_WINDOW = 0.01
"""Time over which speed and torque are judged, so that one noisy sample does not stop the run [s]."""
_JUMP_FACTOR = 2.0
"""Largest plausible change of position between two answers, as a multiple of the speed limit."""

JointArray = NDArray[np.float64] | Sequence[float]


class Supervisor:
    """Checker of successive samples."""

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._limits = rig.limits
        self._units = rig.position_units
        self._window = max(2, round(_WINDOW * rig.rate))
        self._max_unanswered = max(2, math.ceil(rig.limits.silence * rig.rate))
        self._joints = [_JointHistory(self._window) for _ in range(rig.dof)]
        self._host = _Silence()
        """The cycles that the host missed."""
        self.worst_following_error = 0.0
        self.offsets = OffsetWatch(rig)

    def standstill(self, position: JointArray) -> str | None:
        """Check the measured joint angles [rad] against the joint range before power, which reveals a wrong zero."""
        limits = self._limits
        for j, angle in enumerate(position):
            if not limits.joint_min <= angle <= limits.joint_max:
                span = f"{limits.joint_min:g} to {limits.joint_max:g} {self._units[j]}"
                return (
                    f"joint {j + 1} stands at {angle:.3f} {self._units[j]}, {span} expected; check zero_offset, gear "
                    "and sign, or home the drive"
                )
        return None

    def note_missed(self, missed: int) -> None:
        """Count the cycles that the host missed before this one, in which the drives got no targets."""
        for _ in range(missed):
            self._host.note(True)
        self._host.note(False)

    def drives(self, sample: Sample) -> str | None:
        """Check for drive faults and missing answers."""
        if sample.trouble is not None:
            return sample.trouble
        for j, (history, position) in enumerate(zip(self._joints, sample.position, strict=True)):
            history.silence.note(math.isnan(position))
            if history.silence.cycles >= self._max_unanswered:
                known = sample.absence[j] if sample.absence else ""
                time = f"{self._limits.silence * 1e3:g} ms"
                if known:
                    return f"joint {j + 1}: no valid answer for {time}: {known}; look for another program on the bus"
                return f"joint {j + 1}: no answer for {time}; check the cable and the drive"
        return None

    def motion(self, sample: Sample, target: JointArray, torque_offset: JointArray | None = None) -> str | None:
        """Check a moving machine; `target` [rad] is what the positions of `sample` should have reached, under the
        torque offsets [N m] of a feed-forward."""
        return self.after_silence(self._motion(sample, target, torque_offset))

    def after_silence(self, reason: str | None) -> str | None:
        """`reason`, behind the silence that it follows: a joint that got no targets has a following error, too."""
        if reason is None:
            return None
        if gap := self._host.recent(self._window, self._max_unanswered):
            return f"the host missed {gap} cycles; close other programs (then {reason})"
        gaps = [history.silence.recent(self._window, self._max_unanswered) for history in self._joints]
        if longest := max(gaps):
            time = f"{longest / self._rig.rate * 1e3:.0f} ms"
            where = f"joint {gaps.index(longest) + 1}"
            return f"{where}: no answer for {time}; check the cable and the drive (then {reason})"
        return reason

    def _motion(self, sample: Sample, target: JointArray, torque_offset: JointArray | None) -> str | None:
        checks = (self._power, self._jump, self._following, self._speed, self._torque)
        for j in range(len(self._joints)):
            for check in checks:
                if (reason := check(j, sample, float(target[j]))) is not None:
                    return f"joint {j + 1}: {reason}"
        return None if torque_offset is None else self._feedforward(sample, target, torque_offset)

    def _feedforward(self, sample: Sample, target: JointArray, torque_offset: JointArray) -> str | None:
        for j in range(len(self._joints)):
            torque, error = measured_torque(self._rig, sample, j), sample.position[j] - float(target[j])
            if (reason := self.offsets.check(j, float(torque_offset[j]), torque, error)) is not None:
                return f"joint {j + 1}: {reason}"
        return None

    def _power(self, j: int, sample: Sample, target: float) -> str | None:
        if sample.power[j] is Power.ON:
            return None
        return f"the drive left operation by itself (now {sample.power[j].value})"

    def _jump(self, j: int, sample: Sample, target: float) -> str | None:
        history, position = self._joints[j], sample.position[j]
        if math.isnan(position):
            history.add_missing()
            return None
        step, cycles = history.add(position)
        possible = _JUMP_FACTOR * self._limits.speed * cycles / self._rig.rate
        if abs(step) <= possible:
            return None
        unit = self._units[j]
        jump = f"position jump of {step:.4f} {unit} in {cycles} cycles"
        return f"{jump}, {possible:.4f} {unit} possible; check the encoder"

    def _following(self, j: int, sample: Sample, target: float) -> str | None:
        error, limit = abs(sample.position[j] - target), self._limits.following_error
        if error > self.worst_following_error:
            self.worst_following_error = error
        if not error > limit:
            return None
        return (
            f"following error {error:.4f} {self._units[j]}, limit {limit:g} {self._units[j]}; look for a collision, "
            "too fast a motion or a wrong zero_offset, gear, counts_per_turn or sign"
        )

    def _speed(self, j: int, sample: Sample, target: float) -> str | None:
        speed = abs(self._joints[j].mean_step) * self._rig.rate
        if speed <= self._limits.speed:
            return None
        return f"speed {speed:.2f} {self._units[j]}/s, limit {self._limits.speed:g} {self._units[j]}/s"

    def _torque(self, j: int, sample: Sample, target: float) -> str | None:
        torque, limit = measured_torque(self._rig, sample, j), self._limits.torque
        history = self._joints[j]
        history.overloaded = history.overloaded + 1 if abs(torque) > limit else 0
        if history.overloaded < self._window:
            return None
        return f"torque {torque:.1f} N m, limit {limit:g} N m; look for a collision, a brake or a wrong gain"


class _Silence:
    """Cycles in which something was missing, the last ones in a row."""

    def __init__(self) -> None:
        self.cycles = 0
        """Those up to now; 0 when the last cycle was complete."""
        self._before = self._since = 0

    def note(self, is_missing: bool) -> None:
        """Count a cycle."""
        if is_missing:
            self.cycles += 1
        elif self.cycles:
            self._before, self._since, self.cycles = self.cycles, 0, 0
        self._since += 1

    def recent(self, shortest: int, recent: int) -> int:
        """Cycles of a silence, at least `shortest`, that goes on or ended within the `recent` ones; else 0."""
        cycles = self.cycles or (self._before if self._since <= recent else 0)
        return cycles if cycles >= shortest else 0


class _JointHistory:
    """Recent history of one joint."""

    def __init__(self, window: int) -> None:
        self.silence = _Silence()
        self.overloaded = 0
        self._last_position = math.nan
        self._missing = 0
        self._steps: deque[float] = deque(maxlen=window)

    def add_missing(self) -> None:
        """Count a cycle without an answer."""
        self._missing += 1

    def add(self, position: float) -> tuple[float, int]:
        """Add a position [rad]; return the change since the last answer and the number of cycles between them."""
        cycles = self._missing + 1
        step = 0.0 if math.isnan(self._last_position) else position - self._last_position
        self._last_position, self._missing = position, 0
        self._steps.append(step / cycles)
        return step, cycles

    @property
    def mean_step(self) -> float:
        """Mean change per cycle over the window [rad]; 0 until the window is full."""
        return sum(self._steps) / len(self._steps) if len(self._steps) == self._steps.maxlen else 0.0
