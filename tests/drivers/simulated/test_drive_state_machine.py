import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.cia402 import Control, State
from drivers.simulated import drive_state_machine

TRANSITIONS = [
    (State.SWITCH_ON_DISABLED, Control.SHUTDOWN, State.READY),
    (State.SWITCH_ON_DISABLED, Control.ENABLE, State.SWITCH_ON_DISABLED),
    (State.SWITCH_ON_DISABLED, Control.SWITCH_ON, State.SWITCH_ON_DISABLED),
    (State.READY, Control.SWITCH_ON, State.SWITCHED_ON),
    (State.READY, Control.DISABLE_VOLTAGE, State.SWITCH_ON_DISABLED),
    (State.READY, Control.QUICK_STOP, State.SWITCH_ON_DISABLED),
    (State.SWITCHED_ON, Control.ENABLE, State.ENABLED),
    (State.SWITCHED_ON, Control.SHUTDOWN, State.READY),
    (State.SWITCHED_ON, Control.DISABLE_VOLTAGE, State.SWITCH_ON_DISABLED),
    (State.SWITCHED_ON, Control.QUICK_STOP, State.SWITCH_ON_DISABLED),
    (State.ENABLED, Control.SWITCH_ON, State.SWITCHED_ON),
    (State.ENABLED, Control.SHUTDOWN, State.READY),
    (State.ENABLED, Control.DISABLE_VOLTAGE, State.SWITCH_ON_DISABLED),
    (State.ENABLED, Control.QUICK_STOP, State.QUICK_STOP),
    (State.ENABLED, Control.ENABLE, State.ENABLED),
    (State.QUICK_STOP, Control.ENABLE, State.QUICK_STOP),
    (State.QUICK_STOP, Control.QUICK_STOP, State.QUICK_STOP),
    (State.QUICK_STOP, Control.DISABLE_VOLTAGE, State.SWITCH_ON_DISABLED),
    (State.FAULT, Control.ENABLE, State.FAULT),
    (State.FAULT, Control.FAULT_RESET, State.SWITCH_ON_DISABLED),
    (State.FAULT_REACTION, Control.DISABLE_VOLTAGE, State.FAULT_REACTION),
]


@pytest.mark.parametrize(("state", "controlword", "expected"), TRANSITIONS)
def test_transition(state: State, controlword: int, expected: State) -> None:
    assert drive_state_machine.after(state, controlword, previous=0) is expected


def test_fault_reset_acts_on_the_rising_edge_only() -> None:
    assert drive_state_machine.after(State.FAULT, Control.FAULT_RESET, previous=Control.FAULT_RESET) is State.FAULT


@given(st.sampled_from(State), st.integers(0, 0xFFFF), st.integers(0, 0xFFFF))
def test_enabled_is_entered_only_from_switched_on(state: State, controlword: int, previous: int) -> None:
    if drive_state_machine.after(state, controlword, previous) is State.ENABLED:
        assert state in (State.SWITCHED_ON, State.ENABLED)
