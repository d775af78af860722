"""The power state machine of the simulated drive; its way to power and back is in `test_drive`."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.cia402 import Controlword
from drivers.simulated import drive_state_machine
from drivers.simulated.drive_state_machine import PowerState


@given(st.sampled_from(PowerState), st.integers(0, 0xFFFF), st.integers(0, 0xFFFF))
def test_enabled_is_entered_only_from_switched_on(state: PowerState, controlword: int, previous: int) -> None:
    if drive_state_machine.next_state(state, controlword, previous) is PowerState.ENABLED:
        assert state in (PowerState.SWITCHED_ON, PowerState.ENABLED)


@pytest.mark.parametrize("state", [PowerState.FAULT, PowerState.FAULT_REACTION])
@given(controlword=st.integers(0, 0xFFFF), previous=st.integers(0, 0xFFFF))
def test_a_fault_is_left_only_when_its_reset_rises(state: PowerState, controlword: int, previous: int) -> None:
    rises = state is PowerState.FAULT and controlword & ~previous & Controlword.FAULT_RESET
    after = drive_state_machine.next_state(state, controlword, previous)
    assert after is (PowerState.SWITCH_ON_DISABLED if rises else state)
