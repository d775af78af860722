import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.cia402 import Controlword
from drivers.simulated import drive_state_machine
from drivers.simulated.drive_state_machine import PowerState

TRANSITIONS = [
    (PowerState.SWITCH_ON_DISABLED, Controlword.SHUTDOWN, PowerState.READY),
    (PowerState.SWITCH_ON_DISABLED, Controlword.ENABLE, PowerState.SWITCH_ON_DISABLED),
    (PowerState.SWITCH_ON_DISABLED, Controlword.SWITCH_ON, PowerState.SWITCH_ON_DISABLED),
    (PowerState.READY, Controlword.SWITCH_ON, PowerState.SWITCHED_ON),
    (PowerState.READY, Controlword.DISABLE_VOLTAGE, PowerState.SWITCH_ON_DISABLED),
    (PowerState.READY, Controlword.QUICK_STOP, PowerState.SWITCH_ON_DISABLED),
    (PowerState.SWITCHED_ON, Controlword.ENABLE, PowerState.ENABLED),
    (PowerState.SWITCHED_ON, Controlword.SHUTDOWN, PowerState.READY),
    (PowerState.SWITCHED_ON, Controlword.DISABLE_VOLTAGE, PowerState.SWITCH_ON_DISABLED),
    (PowerState.SWITCHED_ON, Controlword.QUICK_STOP, PowerState.SWITCH_ON_DISABLED),
    (PowerState.ENABLED, Controlword.SWITCH_ON, PowerState.SWITCHED_ON),
    (PowerState.ENABLED, Controlword.SHUTDOWN, PowerState.READY),
    (PowerState.ENABLED, Controlword.DISABLE_VOLTAGE, PowerState.SWITCH_ON_DISABLED),
    (PowerState.ENABLED, Controlword.QUICK_STOP, PowerState.QUICK_STOP),
    (PowerState.ENABLED, Controlword.ENABLE, PowerState.ENABLED),
    (PowerState.QUICK_STOP, Controlword.ENABLE, PowerState.QUICK_STOP),
    (PowerState.QUICK_STOP, Controlword.QUICK_STOP, PowerState.QUICK_STOP),
    (PowerState.QUICK_STOP, Controlword.DISABLE_VOLTAGE, PowerState.SWITCH_ON_DISABLED),
    (PowerState.FAULT, Controlword.ENABLE, PowerState.FAULT),
    (PowerState.FAULT, Controlword.FAULT_RESET, PowerState.SWITCH_ON_DISABLED),
    (PowerState.FAULT_REACTION, Controlword.DISABLE_VOLTAGE, PowerState.FAULT_REACTION),
]


@pytest.mark.parametrize(("state", "controlword", "expected"), TRANSITIONS)
def test_transition(state: PowerState, controlword: int, expected: PowerState) -> None:
    assert drive_state_machine.next_state(state, controlword, previous=0) is expected
    # A reset acts on its rising edge only.
    again = drive_state_machine.next_state(state, controlword, previous=Controlword.FAULT_RESET)
    assert again is (state if state is PowerState.FAULT else expected)


@given(st.sampled_from(PowerState), st.integers(0, 0xFFFF), st.integers(0, 0xFFFF))
def test_enabled_is_entered_only_from_switched_on(state: PowerState, controlword: int, previous: int) -> None:
    if drive_state_machine.next_state(state, controlword, previous) is PowerState.ENABLED:
        assert state in (PowerState.SWITCHED_ON, PowerState.ENABLED)
