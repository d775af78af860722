"""Data of the cycle in the recorded file."""

import math
from pathlib import Path

import numpy as np

from daq.cycle.recorder import Recorder
from daq.passive.listen import _run
from drivers.protocol import Power, Sample
from recordings.reader import read
from recordings.rig import simulated_rig
from recordings.writer import RecordingWriter

START = 1_700_000_000_000_000_000
RIG = simulated_rig()


def recorded(path: Path, position_stamp: tuple[int, ...] | None) -> None:
    recorder = Recorder(RecordingWriter(path, RIG, _run(RIG)))
    for k in range(3):
        stamp = START + k * 2_000_000
        delays = None if position_stamp is None else tuple(stamp + late for late in position_stamp)
        sample = Sample(
            position=(0.1, math.nan, 0.3),
            voltage=(1.0, math.nan, 3.0),
            statusword=(0x27, 0, 0x27),
            error_code=(0, 0, 0),
            power=(Power.ON,) * 3,
            missing=1,
            trouble=None,
            position_stamp=delays,
            voltage_stamp=None if delays is None else tuple(late + 1_000 for late in delays),
        )
        recorder.cycle(stamp, stamp, k, 0, 0.0, np.zeros(3), None, sample)
    recorder.close(0, "done")


def test_delays_of_late_measurements_are_recorded(tmp_path: Path) -> None:
    recorded(tmp_path / "r.mcap", (500_000, 0, 3_000_000))
    extra = read(tmp_path / "r.mcap").extra
    np.testing.assert_allclose(extra["position_delay_1"], [0.0005] * 3)
    np.testing.assert_allclose(extra["voltage_delay_3"], [0.003001] * 3)
    assert np.isnan(extra["position_delay_2"]).all()


def test_values_measured_at_sync_have_no_delay(tmp_path: Path) -> None:
    recorded(tmp_path / "r.mcap", None)
    assert not read(tmp_path / "r.mcap").extra
