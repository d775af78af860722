"""What a recording holds, as arrays: the form in which every later stage sees it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from recordings.config import ConfigSection
from recordings.rig import Rig
from recordings.schemas import Level

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]
Words = NDArray[np.uint16]
"""As drives send them: an hour of them need not take the memory of measurements."""


class Run(ConfigSection):
    """One run: the metadata record `run` of a recording."""

    trajectory: str
    trajectory_digest: str
    period: float
    """Duration of one repetition of the motion [s]; 0 where the motion does not repeat."""
    cycles: int
    """Repetitions of the motion."""
    rate: float
    """SYNCs per second [Hz]."""
    software: str
    simulated: bool
    pace: Literal["lockstep", "realtime"]
    seed: int | None = None
    """Seed of the simulated rig's noise; None where nothing random was drawn by us."""
    start: str
    """ISO 8601 time of the first SYNC; the epoch in lockstep, where time is simulated."""
    exit_status: int | None = None
    """0 done, 1 failed; None: the recording was interrupted."""
    reason: str | None = None
    """Why the run ended."""


@dataclass(frozen=True)
class Event:
    """One line of `/events`."""

    time: float
    """Host time from the first SYNC [s]."""
    level: Level
    source: str
    message: str


@dataclass(frozen=True, eq=False)
class Recording:
    """A recording with n cycles of a mechanism with dof joints. NaN is a gap: a sample that was not received."""

    path: Path
    rig: Rig
    run: Run
    time: Floats
    """(n,) SYNC instants from the first one [s]; imported samples need not be evenly spaced."""
    position: Floats
    """(n, dof) measured joint position at the SYNC [rad]."""
    command: Floats
    """(n, dof) reference that was sent for this SYNC [rad]."""
    voltage: Floats
    """(n, dof) signed operating voltage [V]."""
    velocity: Floats | None
    """(n, dof) [rad/s], only if the drives measure it."""
    effort: Floats | None
    """(n, dof) torque actual (object 6077) [N m], only if the drives measure it."""
    statusword: Words
    """(n, dof)."""
    error_code: Words
    """(n, dof)."""
    repeat: Ints
    """(n,) repetition of the motion this sample belongs to, 0 to cycles - 1; -1 while approaching and stopping."""
    lateness: Floats
    """(n,) how late the host began the cycle [s]."""
    events: tuple[Event, ...]
    extra: Mapping[str, Floats] = field(default_factory=dict)
    """Name: (n,) numbers of another program that were imported with the samples."""

    @property
    def complete(self) -> bool:
        """False where the recording was interrupted."""
        return self.run.exit_status is not None

    @property
    def gaps(self) -> Ints:
        """(dof,) number of samples lost per joint."""
        counts: Ints = np.isnan(self.position).sum(axis=0, dtype=np.int64)
        return counts


@dataclass(frozen=True, eq=False)
class CanFrames:
    """The n frames of a recording in the order in which they were logged."""

    stamp: Ints
    """(n,) each frame's own time [ns]."""
    log: Ints
    """(n,) the host's arrival time [ns]."""
    id: Ints
    """(n,) arbitration id."""
    dlc: Ints
    """(n,) number of data bytes."""
    data: NDArray[np.uint8]
    """(n, 8) data bytes, zero behind dlc."""
    sent: Bools
    """(n,) True for the frames that we sent, False for those received."""
    rtr: Bools
    extended: Bools
    error: Bools
