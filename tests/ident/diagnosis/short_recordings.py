"""Recordings of a few seconds with a known cause, made when the tests run, and the verdict that each must get."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ident.diagnosis.diagnosis import DiagnosisOptions, diagnose
from ident.diagnosis.document import verdict
from ident.diagnosis.document.document import Document
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from recordings.recording import Floats, Recording
from tests.ident import building
from tests.ident.conftest import write_recording

NOISE = 0.05
"""Standard deviation of the torque's noise [N m]; the RMS of the torque is 3 to 4 N m."""
CYCLES = 2
"""Of four seconds."""
Torque = Callable[[Motion], Floats]
"""(n, joints) torque of a motion [N m]."""
Change = Callable[[Recording], Recording]
"""What happens to a recording after the motion: a delay, spikes, a limit."""


@dataclass(frozen=True)
class Case:
    """Recordings of independent axes, and what a diagnosis must say of them."""

    guards: str
    """The idea of search or judge that this case needs."""
    torque: Torque | None = None
    """Hidden from the mechanism."""
    named: tuple[str, ...] = ()
    """The effects that are found, sorted; none may be confusable with another."""
    verdict: str = ""
    """Empty: `missing-effect` where effects are named, else `adequate`."""
    joints: tuple[int, ...] = (1,)
    """From 1, on which the effects that are named act."""
    likely: tuple[str, ...] = ()
    refused: Mapping[str, str] = field(default_factory=dict)
    """By the name of a rejected effect: the rule that decided."""
    problems: tuple[str, ...] = ()
    """Kinds of data problems."""
    dof: int = 1
    noise: float = NOISE
    held_out: bool = True
    """Whether there is another recording; else phase segments are held out."""
    motion: Mapping[str, Any] = field(default_factory=dict)
    """Options of `building.record`."""
    change: Change = lambda recording: recording
    only: tuple[str, ...] = ()
    """Effects that the user asks for; the others are not tried."""

    @property
    def expected(self) -> str:
        """The verdict."""
        return self.verdict or ("missing-effect" if self.named else "adequate")


def document_of(case: Case, folder: Path) -> Document:
    """Record and diagnose `case` in the empty `folder`."""
    files = [_written(case, folder / f"{number}.mcap", number) for number in range(1 + case.held_out)]
    options = DiagnosisOptions(only=case.only)
    return verdict.to_document(diagnose(files[:1], files[1:], library(), options))


def _written(case: Case, path: Path, number: int) -> Path:
    options = {"cycles": CYCLES, "shape": number, **case.motion}
    recording = building.record(case.dof, noise=case.noise, seed=number + 1, extra=case.torque, **options)
    return write_recording(replace(case.change(recording), path=path))


def delayed(seconds: float) -> Change:
    """Return what delays the effect of the torque: the drive gives it `seconds` before the motion needs it."""

    def change(recording: Recording) -> Recording:
        assert recording.effort is not None
        columns = [np.interp(recording.time + seconds, recording.time, column) for column in recording.effort.T]
        return replace(recording, effort=np.stack(columns, axis=1))

    return change


def with_spikes(count: int, size: float) -> Change:
    """Return what replaces `count` samples of the torque by `size` [N m]."""

    def change(recording: Recording) -> Recording:
        assert recording.effort is not None
        effort = recording.effort.copy()
        rows = np.random.default_rng(5).choice(len(effort), count, replace=False)
        effort[rows, 0] = size * np.where(np.arange(count) % 2, 1.0, -1.0)
        return replace(recording, effort=effort)

    return change


def unrepeated(recording: Recording) -> Recording:
    """The `recording` as one of a motion that does not repeat."""
    run = recording.run.model_copy(update={"cycles": 1, "period": float(recording.time[-1])})
    return replace(recording, run=run, repeat=np.zeros_like(recording.repeat))


def of_noise(recording: Recording) -> Recording:
    """The `recording` with white noise in place of the torque."""
    assert recording.effort is not None
    return replace(recording, effort=4.0 * np.random.default_rng(9).normal(size=recording.effort.shape))


def on_joint(number: int, torque: Torque) -> Torque:
    """`torque` (n, joints) on joint `number` (from 1) alone."""
    return lambda motion: torque(motion) * (np.arange(motion.position.shape[1]) == number - 1)
