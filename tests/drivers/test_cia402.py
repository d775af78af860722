import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers import cia402
from drivers.cia402 import Control, State
from drivers.protocol import Goal, Power

# IEC 61800-7-201, table of statuswords: xxxx xxxx x0xx 0000 and so on, with bits the state does not use set.
STATUSWORDS = {
    0x0000: State.NOT_READY,
    0x0240: State.SWITCH_ON_DISABLED,
    0x0250: State.SWITCH_ON_DISABLED,
    0x0231: State.READY,
    0x0233: State.SWITCHED_ON,
    0x1237: State.ENABLED,
    0x0217: State.QUICK_STOP,
    0x021F: State.FAULT_REACTION,
    0x0218: State.FAULT,
    0x0208: State.FAULT,
}


@pytest.mark.parametrize(("word", "state"), STATUSWORDS.items())
def test_statusword_tells_the_state(word: int, state: State) -> None:
    assert cia402.decode(word) is state


@pytest.mark.parametrize("state", State)
def test_status_bits_decode_to_their_state(state: State) -> None:
    assert cia402.decode(cia402.STATUS_BITS[state]) is state


@given(st.integers(0, 0xFFFF))
def test_every_word_is_the_state_of_its_bits_or_refused(word: int) -> None:
    fitting = [state for mask, value, state in cia402._PATTERNS if word & mask == value]
    assert len(fitting) <= 1
    if fitting:
        assert cia402.decode(word) is fitting[0]
    else:
        with pytest.raises(ValueError, match=f"0x{word:04X}"):
            cia402.decode(word)


@pytest.mark.parametrize(
    ("state", "command"),
    [
        (State.SWITCH_ON_DISABLED, Control.SHUTDOWN),
        (State.READY, Control.SWITCH_ON),
        (State.SWITCHED_ON, Control.ENABLE),
        (State.ENABLED, Control.ENABLE),
        (State.QUICK_STOP, Control.DISABLE_VOLTAGE),
        (State.FAULT, Control.DISABLE_VOLTAGE),
        (State.FAULT_REACTION, Control.DISABLE_VOLTAGE),
        (State.NOT_READY, Control.DISABLE_VOLTAGE),
    ],
)
def test_way_to_enabled(state: State, command: int) -> None:
    assert cia402.controlword(Goal.ENABLED, state) == command


@pytest.mark.parametrize("state", State)
@pytest.mark.parametrize("goal", [Goal.STOPPED, Goal.DISABLED])
def test_no_way_down_leads_through_enabled(goal: Goal, state: State) -> None:
    command = cia402.controlword(goal, state)
    assert command & 0x0F != Control.ENABLE
    assert command & 0x80 == 0


def test_only_enabled_and_stopping_have_torque() -> None:
    with_torque = {state for state, power in cia402.POWER.items() if power in (Power.ON, Power.STOPPING)}
    assert with_torque == {State.ENABLED, State.QUICK_STOP, State.FAULT_REACTION}
