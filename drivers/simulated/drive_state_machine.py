"""The CiA 402 power state machine in the drive: its states, their statusword, effect of a controlword in each state.

Written without `drivers.cia402`, which the simulated drive tests.
"""

from enum import Enum


class PowerState(Enum):
    """Power states; the value is the statusword's bits 0-3, 5 and 6."""

    SWITCH_ON_DISABLED = 0x40
    READY = 0x21
    SWITCHED_ON = 0x23
    ENABLED = 0x27
    QUICK_STOP = 0x07
    FAULT_REACTION = 0x0F
    FAULT = 0x08


_SHUTDOWN, _SWITCH_ON, _ENABLE, _DISABLE_VOLTAGE, _QUICK_STOP = range(5)

# Transition numbers as in the standard's figure.
_TRANSITIONS: dict[tuple[PowerState, int], PowerState] = {
    (PowerState.SWITCH_ON_DISABLED, _SHUTDOWN): PowerState.READY,  # 2
    (PowerState.READY, _SWITCH_ON): PowerState.SWITCHED_ON,  # 3
    (PowerState.READY, _ENABLE): PowerState.SWITCHED_ON,  # 3, the first half of the automatic 3 + 4
    (PowerState.READY, _DISABLE_VOLTAGE): PowerState.SWITCH_ON_DISABLED,  # 7
    (PowerState.READY, _QUICK_STOP): PowerState.SWITCH_ON_DISABLED,  # 7
    (PowerState.SWITCHED_ON, _ENABLE): PowerState.ENABLED,  # 4
    (PowerState.SWITCHED_ON, _SHUTDOWN): PowerState.READY,  # 6
    (PowerState.SWITCHED_ON, _DISABLE_VOLTAGE): PowerState.SWITCH_ON_DISABLED,  # 10
    (PowerState.SWITCHED_ON, _QUICK_STOP): PowerState.SWITCH_ON_DISABLED,  # 10
    (PowerState.ENABLED, _SWITCH_ON): PowerState.SWITCHED_ON,  # 5
    (PowerState.ENABLED, _SHUTDOWN): PowerState.READY,  # 8
    (PowerState.ENABLED, _DISABLE_VOLTAGE): PowerState.SWITCH_ON_DISABLED,  # 9
    (PowerState.ENABLED, _QUICK_STOP): PowerState.QUICK_STOP,  # 11
    (PowerState.QUICK_STOP, _DISABLE_VOLTAGE): PowerState.SWITCH_ON_DISABLED,  # 12
}

_FAULT_RESET_BIT = 0x80


def next_state(state: PowerState, controlword: int, previous: int) -> PowerState:
    """State after a controlword, given the previous controlword (fault reset acts on its rising edge)."""
    if state is PowerState.FAULT:
        rising = controlword & _FAULT_RESET_BIT and not previous & _FAULT_RESET_BIT
        return PowerState.SWITCH_ON_DISABLED if rising else PowerState.FAULT  # 15
    return _TRANSITIONS.get((state, _command(controlword)), state)


def _command(controlword: int) -> int:
    if not controlword & 0x2:
        return _DISABLE_VOLTAGE
    if not controlword & 0x4:
        return _QUICK_STOP
    if not controlword & 0x1:
        return _SHUTDOWN
    return _ENABLE if controlword & 0x8 else _SWITCH_ON
