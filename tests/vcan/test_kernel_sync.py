"""SYNC from the kernel's broadcast manager: in time, behind its targets, and over when the recorder is."""

import signal
from itertools import pairwise
from pathlib import Path

import can
import numpy as np
import pytest

from recordings.reader import read, read_can
from tests.vcan.conftest import Bench, Frames, wait_until_moving

pytestmark = pytest.mark.vcan

RATE = 100.0
_LATE = 0.05
"""Share of the targets that a busy machine may send after their SYNC; a wrong order would make all of them late."""


def test_the_kernel_keeps_time_and_every_sync_finds_fresh_targets(tmp_path: Path, out: Path) -> None:
    bench = Bench(tmp_path, rate=RATE, sync="kernel")
    file = out / "kernel_sync.mcap"
    file.unlink(missing_ok=True)
    with bench.simulated_rig("realtime"):
        done = bench.record(file, "realtime", "--cycles", "1")
        assert done.code == 0, done.err
    recording, frames = read(file), read_can(file)
    syncs = np.flatnonzero(frames.id == 0x80)
    assert frames.sent[syncs].all()
    unanswered = np.isnan(recording.position).all(axis=1)
    assert len(recording.time) - unanswered.sum() <= len(syncs) <= len(recording.time)
    # No drift: the kernel's own stamps lie on the line of the configured period.
    index = np.rint((frames.stamp[syncs] - frames.stamp[syncs[0]]) * RATE / 1e9)
    period = np.polyfit(index, frames.stamp[syncs] / 1e9, 1)[0]
    assert period == pytest.approx(1 / RATE, rel=1e-4)
    # Between two SYNCs each drive got a target, but for a few where the machine was late: the kernel does not wait.
    stale = sum(
        Frames((int(number), "") for number in frames.id[before:after])[0x200 + node, ""] == 0
        for before, after in pairwise(syncs)
        for node in (1, 2, 3)
    )
    assert stale < _LATE * 3 * len(syncs)


def test_sync_ends_with_a_killed_recorder(tmp_path: Path) -> None:
    bench = Bench(tmp_path, rate=RATE, sync="kernel")
    with bench.simulated_rig("realtime"), bench.recording(tmp_path / "killed.mcap", "realtime") as process:
        wait_until_moving(process, cycles=50)
        process.send_signal(signal.SIGKILL)
        process.wait()
        with can.Bus(
            interface="socketcan", channel="vcan0", can_filters=[{"can_id": 0x80, "can_mask": 0x7FF}]
        ) as bus:
            assert bus.recv(1.0) is None
