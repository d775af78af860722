"""`daq record` and `daq sim` as two processes on the kernel's own SocketCAN."""

import json
from pathlib import Path

import numpy as np
import pytest

from recordings.reader import read, read_can
from tests.vcan.conftest import Bench, Frames

pytestmark = pytest.mark.vcan

ASKED = "4000100000000000"
"""What is object 1000?"""


def test_fig5a_in_lockstep_and_candump_sees_every_recorded_frame(tmp_path: Path, out: Path) -> None:
    bench = Bench(tmp_path, rate=500)
    file = out / "recorded.mcap"
    file.unlink(missing_ok=True)
    with bench.candump() as seen, bench.simulated_rig("lockstep"):
        done = bench.record(file, "lockstep", "--json")
        assert done.code == 0, done.err
    figures = json.loads(done.out)
    assert (figures["answers_lost"], figures["cycles_missed"]) == (0, 0)
    recording = read(file)
    assert recording.run.exit_status == 0
    assert len(recording.time) == figures["cycles"] > 11_000
    assert not np.isnan(recording.position).any()
    # Before the recorder comes, the simulated rig asks for others under its node ids, and the drives boot.
    before = {(0x700 + node, "00"): 1 for node in (1, 2, 3)} | {(0x600 + node, ASKED): 1 for node in (1, 2, 3)}
    assert _recorded(file) == seen - Frames(before)


def test_real_time_accounts_for_every_frame(tmp_path: Path) -> None:
    bench = Bench(tmp_path, rate=100)
    file = tmp_path / "realtime.mcap"
    with bench.candump() as seen, bench.simulated_rig("realtime"):
        done = bench.record(file, "realtime", "--cycles", "1", "--json")
        assert done.code == 0, done.err
    figures, recording, frames = json.loads(done.out), read(file), read_can(file)
    assert len(recording.time) == figures["cycles"] + figures["cycles_missed"]
    assert recording.gaps.sum() == figures["answers_lost"] + 3 * figures["cycles_missed"]
    assert (frames.id == 0x80).sum() == figures["cycles"]
    # The drives answered every SYNC, and each answer is in the file, be it in time or too late for its cycle.
    for node in (1, 2, 3):
        assert (frames.id == 0x180 + node).sum() == figures["cycles"]
    # The drives' heartbeats go on when the recorder has left the bus, and began before it came.
    assert not _recorded(file) - seen
    assert {arbitration_id for arbitration_id, _ in seen - _recorded(file)} <= {
        0x701,
        0x702,
        0x703,
        0x601,
        0x602,
        0x603,
    }


def _recorded(file: Path) -> Frames:
    frames = read_can(file)
    return Frames(
        (int(number), bytes(data[:length]).hex())
        for number, data, length in zip(frames.id, frames.data, frames.dlc, strict=True)
    )
