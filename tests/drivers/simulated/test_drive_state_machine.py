import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.cia402 import Controlword, DriveState
from drivers.simulated import drive_state_machine

TRANSITIONS = [
    (DriveState.SWITCH_ON_DISABLED, Controlword.SHUTDOWN, DriveState.READY),
    (DriveState.SWITCH_ON_DISABLED, Controlword.ENABLE, DriveState.SWITCH_ON_DISABLED),
    (DriveState.SWITCH_ON_DISABLED, Controlword.SWITCH_ON, DriveState.SWITCH_ON_DISABLED),
    (DriveState.READY, Controlword.SWITCH_ON, DriveState.SWITCHED_ON),
    (DriveState.READY, Controlword.DISABLE_VOLTAGE, DriveState.SWITCH_ON_DISABLED),
    (DriveState.READY, Controlword.QUICK_STOP, DriveState.SWITCH_ON_DISABLED),
    (DriveState.SWITCHED_ON, Controlword.ENABLE, DriveState.ENABLED),
    (DriveState.SWITCHED_ON, Controlword.SHUTDOWN, DriveState.READY),
    (DriveState.SWITCHED_ON, Controlword.DISABLE_VOLTAGE, DriveState.SWITCH_ON_DISABLED),
    (DriveState.SWITCHED_ON, Controlword.QUICK_STOP, DriveState.SWITCH_ON_DISABLED),
    (DriveState.ENABLED, Controlword.SWITCH_ON, DriveState.SWITCHED_ON),
    (DriveState.ENABLED, Controlword.SHUTDOWN, DriveState.READY),
    (DriveState.ENABLED, Controlword.DISABLE_VOLTAGE, DriveState.SWITCH_ON_DISABLED),
    (DriveState.ENABLED, Controlword.QUICK_STOP, DriveState.QUICK_STOP),
    (DriveState.ENABLED, Controlword.ENABLE, DriveState.ENABLED),
    (DriveState.QUICK_STOP, Controlword.ENABLE, DriveState.QUICK_STOP),
    (DriveState.QUICK_STOP, Controlword.QUICK_STOP, DriveState.QUICK_STOP),
    (DriveState.QUICK_STOP, Controlword.DISABLE_VOLTAGE, DriveState.SWITCH_ON_DISABLED),
    (DriveState.FAULT, Controlword.ENABLE, DriveState.FAULT),
    (DriveState.FAULT, Controlword.FAULT_RESET, DriveState.SWITCH_ON_DISABLED),
    (DriveState.FAULT_REACTION, Controlword.DISABLE_VOLTAGE, DriveState.FAULT_REACTION),
]


@pytest.mark.parametrize(("state", "controlword", "expected"), TRANSITIONS)
def test_transition(state: DriveState, controlword: int, expected: DriveState) -> None:
    assert drive_state_machine.next_state(state, controlword, previous=0) is expected


def test_fault_reset_acts_on_the_rising_edge_only() -> None:
    assert (
        drive_state_machine.next_state(DriveState.FAULT, Controlword.FAULT_RESET, previous=Controlword.FAULT_RESET)
        is DriveState.FAULT
    )


@given(st.sampled_from(DriveState), st.integers(0, 0xFFFF), st.integers(0, 0xFFFF))
def test_enabled_is_entered_only_from_switched_on(state: DriveState, controlword: int, previous: int) -> None:
    if drive_state_machine.next_state(state, controlword, previous) is DriveState.ENABLED:
        assert state in (DriveState.SWITCHED_ON, DriveState.ENABLED)
