"""The drive's side of the CiA 402 power state machine: what a controlword does in each state."""

from drivers.cia402 import State

_SHUTDOWN, _SWITCH_ON, _ENABLE, _DISABLE_VOLTAGE, _QUICK_STOP = range(5)

# Transition numbers as in the standard's figure.
_TRANSITIONS: dict[tuple[State, int], State] = {
    (State.SWITCH_ON_DISABLED, _SHUTDOWN): State.READY,  # 2
    (State.READY, _SWITCH_ON): State.SWITCHED_ON,  # 3
    (State.READY, _ENABLE): State.SWITCHED_ON,  # 3, the first half of the automatic 3 + 4
    (State.READY, _DISABLE_VOLTAGE): State.SWITCH_ON_DISABLED,  # 7
    (State.READY, _QUICK_STOP): State.SWITCH_ON_DISABLED,  # 7
    (State.SWITCHED_ON, _ENABLE): State.ENABLED,  # 4
    (State.SWITCHED_ON, _SHUTDOWN): State.READY,  # 6
    (State.SWITCHED_ON, _DISABLE_VOLTAGE): State.SWITCH_ON_DISABLED,  # 10
    (State.SWITCHED_ON, _QUICK_STOP): State.SWITCH_ON_DISABLED,  # 10
    (State.ENABLED, _SWITCH_ON): State.SWITCHED_ON,  # 5
    (State.ENABLED, _SHUTDOWN): State.READY,  # 8
    (State.ENABLED, _DISABLE_VOLTAGE): State.SWITCH_ON_DISABLED,  # 9
    (State.ENABLED, _QUICK_STOP): State.QUICK_STOP,  # 11
    (State.QUICK_STOP, _DISABLE_VOLTAGE): State.SWITCH_ON_DISABLED,  # 12
}

_FAULT_RESET_BIT = 0x80


def after(state: State, controlword: int, previous: int) -> State:
    """The state after a controlword, given the controlword before it (fault reset acts on its rising edge)."""
    if state is State.FAULT:
        rising = controlword & _FAULT_RESET_BIT and not previous & _FAULT_RESET_BIT
        return State.SWITCH_ON_DISABLED if rising else State.FAULT  # 15
    return _TRANSITIONS.get((state, _command(controlword)), state)


def _command(controlword: int) -> int:
    if not controlword & 0x2:
        return _DISABLE_VOLTAGE
    if not controlword & 0x4:
        return _QUICK_STOP
    if not controlword & 0x1:
        return _SHUTDOWN
    return _ENABLE if controlword & 0x8 else _SWITCH_ON
