"""`daq record` and `daq sim` as two processes on the kernel's own SocketCAN."""

from pathlib import Path

import numpy as np
import pytest

from recordings.reader import read, read_can
from tests.running import accounted_for
from tests.vcan.conftest import Bench, Frames, Run

pytestmark = pytest.mark.vcan

ASKED = "4000100000000000"
"""SDO request to read object 1000."""


def test_candump_sees_every_recorded_frame_of_fig5a_in_lockstep(tmp_path: Path, out: Path) -> None:
    bench = Bench(tmp_path, rate=500)
    file = out / "recorded.mcap"
    with bench.candump() as bus_frames, bench.simulated_rig("lockstep"):
        done = bench.record(file, "lockstep", "--json")
        figures = done.figures
    assert (figures["answers_lost"], figures["cycles_missed"]) == (0, 0)
    recording = read(file)
    assert recording.run.exit_status == 0
    assert len(recording.time) == figures["cycles"] > 11_000
    assert not np.isnan(recording.position).any()
    # Before the recorder starts, the simulated rig checks that its node ids are free, and the drives boot.
    before = {(0x700 + node, "00"): 1 for node in (1, 2, 3)} | {(0x600 + node, ASKED): 1 for node in (1, 2, 3)}
    assert _recorded(file) == bus_frames - Frames(before)


@pytest.fixture(scope="module")
def realtime(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """One cycle of fig5a."""
    bench = Bench(tmp_path_factory.mktemp("realtime"), rate=25)
    return bench.record_watched(bench.folder / "realtime.mcap")


def test_real_time_accounts_for_every_frame(realtime: Run) -> None:
    figures = realtime.done.figures
    _, frames = accounted_for(realtime.file, figures)
    assert (frames.id == 0x80).sum() == figures["cycles"]
    # The drives answered every SYNC, and the file has each answer, in time or too late for its cycle.
    for node in (1, 2, 3):
        assert (frames.id == 0x180 + node).sum() == figures["cycles"]
    # The drives send heartbeats before the recorder starts and after it has ended.
    recorded, bus_frames = _recorded(realtime.file), realtime.bus_frames
    assert not recorded - bus_frames
    assert {arbitration_id for arbitration_id, _ in bus_frames - recorded} <= {
        kind + node for kind in (0x600, 0x700) for node in (1, 2, 3)
    }


def test_in_real_time_few_answers_are_lost(realtime: Run) -> None:
    figures = realtime.done.figures
    lost = (figures["answers_lost"] + 3 * figures["cycles_missed"]) / (3 * figures["cycles"])
    realtime.machine.expect(lost < 0.05, f"{lost:.0%} of the answers were lost")


def _recorded(file: Path) -> Frames:
    frames = read_can(file)
    return Frames(
        (int(number), bytes(data[:length]).hex())
        for number, data, length in zip(frames.id, frames.data, frames.dlc, strict=True)
    )
