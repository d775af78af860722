"""A recording is replayed on vcan0 while another recorder listens; `same_fit.py` then fits both outside."""

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

from recordings.reader import read
from tests.conftest import launcher
from tests.vcan.conftest import Bench, finished

pytestmark = pytest.mark.vcan

CYCLES = ("--cycles", "2")
RATE = 100.0
"""[Hz]: what one slow processor replays and hears in time."""


def test_what_is_listened_to_is_what_was_recorded(tmp_path: Path, out: Path) -> None:
    bench = Bench(tmp_path, rate=RATE)
    first, second = out / "first.mcap", out / "second.mcap"
    for file in (first, second):
        file.unlink(missing_ok=True)
    with bench.simulated_rig("lockstep"):
        done = bench.record(first, "lockstep", *CYCLES)
        assert done.code == 0, done.err
    listen = [
        "record",
        "--listen",
        "--rig",
        str(bench.rig),
        "--traj",
        "fig5a",
        *CYCLES,
        "--out",
        str(second),
        "--json",
    ]
    with subprocess.Popen(
        [*launcher("daq"), *listen], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as listener:
        assert listener.stderr is not None
        assert "sending nothing" in listener.stderr.readline()
        replay = ["replay", str(first), "--bus", "socketcan:vcan0", "--direction", "both", "--yes"]
        replayed = subprocess.run([*launcher("daq"), *replay], capture_output=True, text=True, timeout=120)
        assert replayed.returncode == 0, replayed.stderr
        heard = finished(listener)
    assert heard.code == 0, heard.err
    assert json.loads(heard.out)["syncs"] == len(read(first).time)
    recorded, listened = read(first), read(second)
    np.testing.assert_array_equal(recorded.position, listened.position)
    np.testing.assert_array_equal(recorded.voltage, listened.voltage)
    np.testing.assert_array_equal(recorded.repeat, listened.repeat)
    np.testing.assert_allclose(np.diff(listened.time), 1 / RATE, rtol=1e-9)
