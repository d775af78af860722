"""The CiA 402 power state machine in the drive: effect of a controlword in each state."""

from drivers.cia402 import DriveState

_SHUTDOWN, _SWITCH_ON, _ENABLE, _DISABLE_VOLTAGE, _QUICK_STOP = range(5)

# Transition numbers as in the standard's figure.
_TRANSITIONS: dict[tuple[DriveState, int], DriveState] = {
    (DriveState.SWITCH_ON_DISABLED, _SHUTDOWN): DriveState.READY,  # 2
    (DriveState.READY, _SWITCH_ON): DriveState.SWITCHED_ON,  # 3
    (DriveState.READY, _ENABLE): DriveState.SWITCHED_ON,  # 3, the first half of the automatic 3 + 4
    (DriveState.READY, _DISABLE_VOLTAGE): DriveState.SWITCH_ON_DISABLED,  # 7
    (DriveState.READY, _QUICK_STOP): DriveState.SWITCH_ON_DISABLED,  # 7
    (DriveState.SWITCHED_ON, _ENABLE): DriveState.ENABLED,  # 4
    (DriveState.SWITCHED_ON, _SHUTDOWN): DriveState.READY,  # 6
    (DriveState.SWITCHED_ON, _DISABLE_VOLTAGE): DriveState.SWITCH_ON_DISABLED,  # 10
    (DriveState.SWITCHED_ON, _QUICK_STOP): DriveState.SWITCH_ON_DISABLED,  # 10
    (DriveState.ENABLED, _SWITCH_ON): DriveState.SWITCHED_ON,  # 5
    (DriveState.ENABLED, _SHUTDOWN): DriveState.READY,  # 8
    (DriveState.ENABLED, _DISABLE_VOLTAGE): DriveState.SWITCH_ON_DISABLED,  # 9
    (DriveState.ENABLED, _QUICK_STOP): DriveState.QUICK_STOP,  # 11
    (DriveState.QUICK_STOP, _DISABLE_VOLTAGE): DriveState.SWITCH_ON_DISABLED,  # 12
}

_FAULT_RESET_BIT = 0x80


def next_state(state: DriveState, controlword: int, previous: int) -> DriveState:
    """State after a controlword, given the previous controlword (fault reset acts on its rising edge)."""
    if state is DriveState.FAULT:
        rising = controlword & _FAULT_RESET_BIT and not previous & _FAULT_RESET_BIT
        return DriveState.SWITCH_ON_DISABLED if rising else DriveState.FAULT  # 15
    return _TRANSITIONS.get((state, _command(controlword)), state)


def _command(controlword: int) -> int:
    if not controlword & 0x2:
        return _DISABLE_VOLTAGE
    if not controlword & 0x4:
        return _QUICK_STOP
    if not controlword & 0x1:
        return _SHUTDOWN
    return _ENABLE if controlword & 0x8 else _SWITCH_ON
