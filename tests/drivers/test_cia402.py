import pytest

from drivers import cia402
from drivers.cia402 import Controlword, DriveState
from drivers.protocol import Goal, Power

# IEC 61800-7-201, table of statuswords: xxxx xxxx x0xx 0000 and so on, with bits the state does not use set.
STATUSWORDS = {
    **{0x0000: DriveState.NOT_READY, 0x0240: DriveState.SWITCH_ON_DISABLED, 0x0250: DriveState.SWITCH_ON_DISABLED},
    **{0x0231: DriveState.READY, 0x0233: DriveState.SWITCHED_ON, 0x1237: DriveState.ENABLED},
    **{0x0217: DriveState.QUICK_STOP, 0x021F: DriveState.FAULT_REACTION},
    **{0x0218: DriveState.FAULT, 0x0208: DriveState.FAULT},
}


def test_statuswords_decode_to_their_states() -> None:
    assert {word: cia402.decode(word) for word in STATUSWORDS} == STATUSWORDS
    assert cia402.decode(0x0003) is None
    assert {state: cia402.decode(bits) for state, bits in cia402.STATUS_BITS.items()} == {s: s for s in DriveState}


def test_enabling_takes_one_state_after_the_other_and_others_get_disable_voltage() -> None:
    assert cia402.next_controlword(Goal.ENABLED, None) == Controlword.DISABLE_VOLTAGE
    commands = {state: cia402.next_controlword(Goal.ENABLED, state) for state in DriveState}
    assert commands == dict.fromkeys(DriveState, Controlword.DISABLE_VOLTAGE) | {
        DriveState.SWITCH_ON_DISABLED: Controlword.SHUTDOWN,
        DriveState.READY: Controlword.SWITCH_ON,
        DriveState.SWITCHED_ON: Controlword.ENABLE,
        DriveState.ENABLED: Controlword.ENABLE,
    }


@pytest.mark.parametrize("state", DriveState)
@pytest.mark.parametrize("goal", [Goal.STOPPED, Goal.DISABLED])
def test_no_controlword_towards_a_stop_enables_or_resets_faults(goal: Goal, state: DriveState) -> None:
    command = cia402.next_controlword(goal, state)
    assert command & 0x0F != Controlword.ENABLE
    assert command & 0x80 == 0
    assert cia402.next_controlword(goal, None) == Controlword.DISABLE_VOLTAGE


def test_only_enabled_and_stopping_have_torque() -> None:
    with_torque = {state for state, power in cia402.POWER.items() if power in (Power.ON, Power.STOPPING)}
    assert with_torque == {DriveState.ENABLED, DriveState.QUICK_STOP, DriveState.FAULT_REACTION}
