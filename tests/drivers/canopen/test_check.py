"""Comparison with the rig file: what a drive's state means before a run."""

from types import SimpleNamespace
from typing import Any, cast

import pytest

from drivers import cia402
from drivers.canopen.check import _state
from drivers.cia402 import DriveState
from drivers.protocol import Power


@pytest.mark.parametrize("state", DriveState)
def test_power_is_a_problem_but_where_the_start_of_a_run_removes_it(state: DriveState) -> None:
    power = cia402.POWER[state]
    has_torque = power in (Power.ON, Power.STOPPING)
    axis = SimpleNamespace(state=state, power=power, has_torque=has_torque, read_state=lambda: None)
    [(_, _, text, verdict)] = _state(
        cast(Any, axis), cast(Any, SimpleNamespace(value=lambda key: 0, tells_status=True))
    )
    expected = {
        DriveState.FAULT: "problem",
        DriveState.FAULT_REACTION: "problem",
        DriveState.ENABLED: "problem",
        DriveState.QUICK_STOP: "noted",
    }
    assert verdict == expected.get(state, "fine")
    assert ("the start of a run switches it off" in text) == (state == DriveState.QUICK_STOP)
