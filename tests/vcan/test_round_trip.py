"""A recording is replayed on vcan0 while another recorder listens; `same_fit.py` later fits both recordings."""

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from recordings.reader import read, read_can
from recordings.recording import Recording
from tests.conftest import launcher
from tests.timekeeping import Machine
from tests.vcan.conftest import Bench, finished, watched

pytestmark = pytest.mark.vcan

CYCLES = ("--cycles", "3")
RATE = 25.0
"""[Hz]: a rate at which one slow processor can replay and record in time."""


@dataclass
class Trip:
    """Two recordings, the listener's figures, and the computer's timekeeping."""

    first: Path
    second: Path
    figures: dict[str, Any]
    machine: Machine


@pytest.fixture(scope="module")
def trip(tmp_path_factory: pytest.TempPathFactory, out: Path) -> Trip:
    """Three cycles of fig5a: enough samples for a fit."""
    bench = Bench(tmp_path_factory.mktemp("round_trip"), rate=RATE)
    first, second = out / "first.mcap", out / "second.mcap"
    with bench.simulated_rig("lockstep"):
        done = bench.record(first, "lockstep", *CYCLES)
    assert done.code == 0, done.err
    with watched() as machine, bench.listening(second, *CYCLES, "--json") as listener:
        replay = ["replay", str(first), "--bus", "socketcan:vcan0", "--direction", "both", "--yes"]
        replayed = subprocess.run([*launcher("daq"), *replay], capture_output=True, text=True, timeout=900)
        assert replayed.returncode == 0, replayed.stderr
        listened = finished(listener)
    assert listened.code == 0, listened.err
    return Trip(first, second, json.loads(listened.out), machine)


def test_listener_records_the_replayed_frames(trip: Trip) -> None:
    sent, listened = read_can(trip.first), read_can(trip.second)
    for name in ("id", "dlc", "data"):
        np.testing.assert_array_equal(getattr(sent, name), getattr(listened, name))
    recorded, second_recording = read(trip.first), read(trip.second)
    assert trip.figures["syncs"] == len(recorded.time)
    # If all SYNCs are late, one may be taken for missing: a row without answers.
    came = ~np.isnan(second_recording.position).all(axis=1)
    np.testing.assert_array_equal(recorded.position, second_recording.position[came])
    np.testing.assert_array_equal(recorded.voltage, second_recording.voltage[came])
    assert recorded.run.torque_age == second_recording.run.torque_age


def test_listener_records_the_replayed_times(trip: Trip) -> None:
    recorded, second_recording = read(trip.first), read(trip.second)
    trip.machine.expect(_same_times(recorded, second_recording), f"listened: {trip.figures}")
    np.testing.assert_array_equal(recorded.repeat, second_recording.repeat)


def _same_times(recorded: Recording, second_recording: Recording) -> bool:
    steps = np.diff(recorded.time), np.diff(second_recording.time)
    return len(steps[0]) == len(steps[1]) and np.allclose(*steps, rtol=1e-9, atol=0.0)
