"""SYNC from the kernel's broadcast manager: complete, in time, and ended with the recorder."""

import signal
from collections import Counter
from itertools import pairwise
from pathlib import Path

import can
import numpy as np
import pytest

from recordings.reader import read_can
from recordings.recording import CanFrames
from tests.running import accounted_for
from tests.vcan.conftest import Bench, Run, wait_until_moving

pytestmark = pytest.mark.vcan

RATE = 25.0
"""[Hz]: even a slow computer sends its targets within 0.3 periods."""
_LATE = 0.05
"""Fraction of the targets that may be sent after their SYNC; a wrong order would delay all of them."""


def syncs_of(frames: CanFrames) -> np.ndarray:
    """Indices of the SYNC frames."""
    return np.flatnonzero(frames.id == 0x80)


def stale(frames: CanFrames) -> list[int]:
    """Number of SYNCs without a new target for each drive, between the first and the last target."""
    targets, syncs = np.flatnonzero(frames.id & 0x780 == 0x200), syncs_of(frames)
    syncs = syncs[(syncs > targets[0]) & (syncs < targets[-1])]
    counts = [Counter(frames.id[before:after].tolist()) for before, after in pairwise(syncs)]
    return [sum(count[0x200 + node] == 0 for count in counts) for node in (1, 2, 3)]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory, out: Path) -> Run:
    """One cycle of fig5a."""
    bench = Bench(tmp_path_factory.mktemp("kernel_sync"), rate=RATE, sync="kernel")
    return bench.record_watched(out / "kernel_sync.mcap")


def test_every_sync_of_the_kernel_is_accounted_for(run: Run) -> None:
    figures, frames = run.done.figures, read_can(run.file)
    syncs = syncs_of(frames)
    assert frames.sent[syncs].all()
    assert len(syncs) == run.bus_frames[0x80, ""]
    assert "while closing" not in run.done.err
    recording, _ = accounted_for(run.file, figures)
    for node in (1, 2, 3):
        assert (frames.id == 0x200 + node).sum() == figures["cycles"]
    answered = ~np.isnan(recording.position).all(axis=1)
    assert answered.sum() <= len(syncs)
    # The kernel does not wait for targets: a SYNC before them is a missed cycle of the host, unless the computer
    # sends them late.
    without, missed = max(stale(frames)), figures["cycles_missed"]
    accounted = without <= missed + _LATE * len(syncs)
    run.machine.expect(accounted, f"{without} SYNCs without a target, {missed} missed cycles")


def test_kernel_keeps_the_period_and_targets_precede_their_sync(run: Run) -> None:
    # No drift: the slope of the kernel's stamps is the configured period.
    frames = read_can(run.file)
    stamps = frames.stamp[syncs_of(frames)] / 1e9
    period = np.polyfit(np.rint((stamps - stamps[0]) * RATE), stamps, 1)[0]
    run.machine.expect(period == pytest.approx(1 / RATE, rel=1e-4), f"SYNC every {1e3 * period:.4f} ms")
    late = sum(stale(frames)) / (3 * len(stamps))
    run.machine.expect(late < _LATE, f"{late:.0%} of the SYNCs came before their targets")


def test_sync_ends_with_a_killed_recorder(tmp_path: Path) -> None:
    bench = Bench(tmp_path, rate=RATE, sync="kernel")
    with bench.simulated_rig("realtime"), bench.recording(tmp_path / "killed.mcap", "realtime") as process:
        wait_until_moving(process, cycles=20)
        process.send_signal(signal.SIGKILL)
        process.wait()
        # Heartbeats show that time passes on the bus: a dozen SYNCs would have been sent.
        heartbeats = Counter[int]()
        with can.Bus(interface="socketcan", channel="vcan0") as bus:
            while min(heartbeats[0x701], heartbeats[0x702], heartbeats[0x703]) < 5:
                message = bus.recv(60)
                assert message is not None, "the drives send nothing"
                heartbeats[message.arbitration_id] += 1
        assert not heartbeats[0x80]
