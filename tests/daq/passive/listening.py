"""Frames of another master and its drives, as a listener records them."""

from pathlib import Path

import numpy as np

from daq.passive import listen
from recordings.reader import read_can
from recordings.recording import CanFrames, Ints
from recordings.rig import Rig
from recordings.writer import RecordingWriter

SAMPLE = Path(__file__).parents[3] / "recordings" / "samples" / "fig5a.mcap"
START = 1_700_000_000_000_000_000


def arrivals(frames: CanFrames, period: float, seed: int, jitter: float = 2e4) -> Ints:
    """Arrival times (n,) [ns] of the frames of a lockstep recording, with this period [ns] and random lateness."""
    rng = np.random.default_rng(seed)
    cycle = np.cumsum(frames.id == 0x80)
    late = rng.exponential(jitter, size=cycle[-1] + 1)
    order = np.arange(len(cycle)) - np.searchsorted(cycle, cycle)
    return START + np.rint(cycle * period + late[cycle] + 1000 * np.minimum(order, 100)).astype(np.int64)


def write(path: Path, rig: Rig, frames: CanFrames, log: Ints, keep: np.ndarray | None = None) -> None:
    """Write a listened recording with frames only, as a killed listener leaves it."""
    with RecordingWriter(path, rig, listen.listened_run(rig)) as writer:
        for k in np.flatnonzero(np.ones(len(log), bool) if keep is None else keep):
            data = bytes(frames.data[k, : frames.dlc[k]])
            writer.can(int(log[k]), int(log[k]), int(frames.id[k]), data, sent=False, rtr=bool(frames.rtr[k]))


def sample_frames() -> CanFrames:
    """The frames of the sample recording of fig5a."""
    return read_can(SAMPLE)
