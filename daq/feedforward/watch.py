"""Supervision of a feed-forward: the drives follow the offset, and it makes nothing worse.

The torque of a drive is its offset plus what its loops add. An offset is worse than none where the loops must add
more than the whole torque: with a linear loop the following error is then larger than it would be without.
"""

import math

import numpy as np

from drivers.protocol import Sample
from recordings.recording import Floats
from recordings.rig import Rig

_WINDOW = 0.1
"""Time over which torques are compared and the following error is judged, so that no late target ends a run [s]."""
_MARGIN = 0.1
"""Share of the rated torque by which the loops may exceed the whole torque: dry friction, errors of measurement."""
_FOLLOWING_SHARE = 0.5
"""Share of limits.following_error that is allowed with an offset."""
_SIGNAL = 0.05
"""Amplitude of the test signal, as a share of the rated torque: too small to move a joint far."""
_SIGNAL_CYCLES = 2
"""Cycles for which the test signal keeps its sign."""
_SIGNAL_CHANGES = 15
"""Odd: the joint ends at rest where it began."""
_LEAST_ANSWER, _LARGEST_ANSWER = 0.25, 2.0
"""Answer to the test signal, over its amplitude: 1 where friction holds the joint, less where the loops oppose it."""
_LEAST_KNOWN = 0.5
"""Share of the cycles of the test in which the torque must be known."""


def probe_signal(rig: Rig) -> Floats:
    """Small offsets (m, dof) [N m] of alternating sign, 0 at the end."""
    half = np.ones(_SIGNAL_CYCLES // 2)
    changes = np.repeat(np.resize([-1.0, 1.0], _SIGNAL_CHANGES), _SIGNAL_CYCLES)
    signs = np.concatenate([half, changes, half, [0.0, 0.0]])
    return _SIGNAL * np.outer(signs, [drive.rated_torque for drive in rig.drives])


def measured_torque(rig: Rig, sample: Sample, joint: int) -> float:
    """Torque of a drive [N m] by its voltage, else as the drive reports it; NaN where neither arrived."""
    volts, gain = sample.voltage[joint], rig.torque.gain[joint]
    torque = gain * (volts * abs(volts) if rig.torque.map == "square" else volts)
    return sample.effort[joint] if math.isnan(torque) and sample.effort is not None else torque


class OffsetWatch:
    """Watch of the offsets of one run."""

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._keep = math.exp(-1 / (_WINDOW * rig.rate))
        self._whole, self._added, self._error = ([0.0] * rig.dof for _ in range(3))
        """Mean squares of the whole torque, of what the loops add, and of the following error."""
        self._answers: list[tuple[Floats, Floats]] = []

    def check(self, joint: int, offset: float, torque: float, error: float) -> str | None:
        """Reason to end the run, or None.

        `torque`: of the drive, under `offset` [N m]; `error`: following error [rad]. NaN: not known in this cycle.
        """
        rated, largest = self._rig.drives[joint].rated_torque, _FOLLOWING_SHARE * self._rig.limits.following_error
        keep = self._keep
        if not math.isnan(error):
            self._error[joint] = keep * self._error[joint] + (1 - keep) * error**2
        # A joint that sags as its brake opens does so without an offset.
        if abs(offset) > _SIGNAL * rated and (rms := math.sqrt(self._error[joint])) > largest:
            return (
                f"following error {rms:.4f} rad (RMS over {_WINDOW:g} s) with a torque offset of {offset:.1f} N m, "
                f"{largest:g} rad allowed; check the model, or run without --feedforward"
            )
        if math.isnan(torque):
            return None
        self._whole[joint] = keep * self._whole[joint] + (1 - keep) * torque**2
        self._added[joint] = keep * self._added[joint] + (1 - keep) * (torque - offset) ** 2
        whole, added = math.sqrt(self._whole[joint]), math.sqrt(self._added[joint])
        if not offset or added <= whole + _MARGIN * rated:
            return None
        return (
            f"the torque offset ({offset:.1f} N m) works against the drive, whose loops add {added:.1f} N m to reach "
            f"{whole:.1f} N m; the model is not one of this robot as it is"
        )

    def note_answer(self, sample: Sample, offset: Floats) -> None:
        """Note how the drives answered an offset (dof,) [N m] of the test signal."""
        torque = np.array([measured_torque(self._rig, sample, j) for j in range(self._rig.dof)])
        self._answers.append((offset, torque))

    def judge_answers(self) -> str | None:
        """Reason to end the run after the test signal, naming the joint; None: every drive follows its offset."""
        offsets, torques = (np.array(column) for column in zip(*self._answers, strict=True))
        # A serial drive is read after its offset was written, and so shows it a cycle sooner.
        sooner = np.concatenate([offsets[1:], offsets[-1:]])
        for j in range(self._rig.dof):
            known = np.isfinite(torques[:, j])
            if known.mean() < _LEAST_KNOWN:
                return (
                    f"joint {j + 1}: its torque is known in {known.mean():.0%} of the cycles, {_LEAST_KNOWN:.0%} "
                    "needed to watch a torque offset; send voltage or torque by PDO"
                )
            answer = max(_answer(offset[known, j], torques[known, j]) for offset in (offsets, sooner))
            if not _LEAST_ANSWER <= answer <= _LARGEST_ANSWER:
                return (
                    f"joint {j + 1}: the drive does not follow its torque offset: its torque changes by {answer:.2f} "
                    f"of it, {_LEAST_ANSWER:g} to {_LARGEST_ANSWER:g} expected; check sign and rated_torque"
                )
        return None


def _answer(offset: Floats, torque: Floats) -> float:
    """Change of `torque` (n,) that goes with `offset` (n,), over that offset; by least squares."""
    return float((offset - offset.mean()) @ (torque - torque.mean()) / (offset @ offset))
