from contextlib import nullcontext
from threading import Event
from typing import Any

import numpy as np
import pytest

from daq.feedforward.planning import ASSUMED_GAIN, Feedforward
from daq.feedforward.source import PlannedTorque
from drivers.protocol import Identity
from recordings.errors import BadInput
from recordings.rig import Torque, simulated_rig
from tests.daq.feedforward.given import GivenTorque
from trajectories import load

RIG = simulated_rig().at_rate(100.0).with_torque_offset()
TRAJECTORY = load("fig5b", RIG, cycles=1)
Log = list[tuple[str, str, str]]


def plan(torque: float) -> tuple[PlannedTorque, Log, int]:
    log, waits, ready = Log(), 0, Event()

    def wait() -> None:
        nonlocal waits
        waits += 1
        if waits == 3:
            ready.set()

    source = GivenTorque(np.full_like(TRAJECTORY.joint_position, torque), ready=ready)
    feedforward = Feedforward(source, RIG, frozenset(), lambda *line: log.append(line))
    planned = feedforward.plan(0.5, TRAJECTORY.joint_position[:5], TRAJECTORY, wait)
    assert not source.cancelled
    return planned, log, waits


def test_time_passes_until_the_torque_is_there_and_both_digests_are_kept() -> None:
    planned, log, waits = plan(5.0)
    assert waits >= 3
    np.testing.assert_array_equal(planned.stream, 5.0)
    assert log == [("info", "feed-forward", "given.csv (SHA-256 d1), table SHA-256 d2")]


def test_torque_beyond_the_limit_is_cut_off_and_said() -> None:
    planned, log, _ = plan(-25.0)
    np.testing.assert_array_equal(planned.stream, -20.0)
    assert log[-1][0] == "warning"
    assert "100% of the torques are cut off at 1 of the rated torque" in log[-1][2]


@pytest.mark.parametrize(
    ("simulated", "gain", "accepted", "refused"),
    [
        (False, "assumed", frozenset(), True),
        (False, "assumed", frozenset({ASSUMED_GAIN}), False),
        (False, "calibrated", frozenset(), False),
        (True, "assumed", frozenset(), False),
    ],
)
def test_assumed_gain_is_refused_on_real_drives(
    simulated: bool, gain: Any, accepted: frozenset[str], refused: bool
) -> None:
    rig = RIG.model_copy(update={"torque": Torque(gain_source=gain)})
    feedforward = Feedforward(GivenTorque(np.zeros((1, 3))), rig, accepted, lambda *line: None)
    with pytest.raises(BadInput, match="--accept assumed-gain") if refused else nullcontext():
        feedforward.check_drives(tuple(Identity(i, "", "", 0, 0, 0, simulated, False) for i in (1, 2, 3)))
