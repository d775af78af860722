"""Data of the cycle in the recorded file."""

import math
from pathlib import Path

import can
import numpy as np
import pytest

from daq.cycle.recorder import Recorder
from daq.passive.listen import listened_run
from drivers.protocol import Power, Sample
from recordings.errors import RunFailed
from recordings.reader import read, read_can
from recordings.rig import simulated_rig
from recordings.writer import RecordingWriter

START = 1_700_000_000_000_000_000
RIG = simulated_rig()


@pytest.mark.parametrize("late", [True, False])
def test_delays_of_late_measurements_are_recorded(late: bool, tmp_path: Path) -> None:
    recorder = Recorder(RecordingWriter(tmp_path / "r.mcap", RIG, listened_run(RIG)))
    for k in range(3):
        stamp = START + k * 2_000_000
        delays = (stamp + 500_000, stamp, stamp + 3_000_000) if late else None
        sample = Sample(
            position=(0.1, math.nan, 0.3),
            voltage=(1.0, math.nan, 3.0),
            statusword=(0x27, 0, 0x27),
            error_code=(0, 0, 0),
            power=(Power.ON,) * 3,
            missing=1,
            trouble=None,
            position_stamp=delays,
            voltage_stamp=None if delays is None else tuple(each + 1_000 for each in delays),
        )
        recorder.cycle(stamp, stamp, k, 0, 0.0, np.zeros(3), None, sample)
    recorder.close(0, "done")
    extra = read(tmp_path / "r.mcap").extra
    if not late:
        assert not extra
        return
    np.testing.assert_allclose(extra["position_delay_1"], [0.0005] * 3)
    np.testing.assert_allclose(extra["voltage_delay_3"], [0.003001] * 3)
    assert np.isnan(extra["position_delay_2"]).all()


def test_a_long_frame_is_cut_and_a_record_that_cannot_be_written_ends_the_run(tmp_path: Path) -> None:
    """Classic CAN has 8 bytes; python-can's virtual and udp_multicast buses carry more."""
    writer = RecordingWriter(tmp_path / "r.mcap", RIG, listened_run(RIG))
    recorder = Recorder(writer)
    recorder.frame(START, can.Message(arbitration_id=0x181, data=bytes(range(9)), is_fd=True), sent=False)
    recorder.event(START, "nonsense", "bus", "no such level")  # type: ignore[arg-type]
    with pytest.raises(RunFailed, match="a record cannot be written: KeyError"):
        recorder.close(0, "done")
    writer.close(1, "as the run ends")
    assert read_can(tmp_path / "r.mcap").data.tolist() == [[*range(8)]]
