"""The power state machine of CiA 402 (IEC 61800-7-201): states, statusword masks and the way to a goal.

The way to "operation enabled" goes up one state at a time; the way down never passes through it.
"""

from enum import Enum

from drivers.protocol import Goal, Power


class State(Enum):
    """Power states. The value is what a person reads."""

    NOT_READY = "not ready to switch on"
    SWITCH_ON_DISABLED = "switch on disabled"
    READY = "ready to switch on"
    SWITCHED_ON = "switched on"
    ENABLED = "operation enabled"
    QUICK_STOP = "quick stop active"
    FAULT_REACTION = "fault reaction active"
    FAULT = "fault"


# Statusword: (mask, value) of each state; bits 0-3, 5, 6 as in the standard's table.
_PATTERNS: tuple[tuple[int, int, State], ...] = (
    (0x4F, 0x00, State.NOT_READY),
    (0x4F, 0x40, State.SWITCH_ON_DISABLED),
    (0x6F, 0x21, State.READY),
    (0x6F, 0x23, State.SWITCHED_ON),
    (0x6F, 0x27, State.ENABLED),
    (0x6F, 0x07, State.QUICK_STOP),
    (0x4F, 0x0F, State.FAULT_REACTION),
    (0x4F, 0x08, State.FAULT),
)

STATUS_BITS: dict[State, int] = {state: value for _, value, state in _PATTERNS}

TARGET_FOLLOWED = 0x1000
"""Statusword bit 12 in the cyclic modes: the drive follows the target."""
FOLLOWING_ERROR = 0x2000
"""Statusword bit 13 in the position modes."""


class Control:
    """Controlword commands."""

    DISABLE_VOLTAGE = 0x0000
    QUICK_STOP = 0x0002
    SHUTDOWN = 0x0006
    SWITCH_ON = 0x0007
    ENABLE = 0x000F
    FAULT_RESET = 0x0080


# A state that is absent here needs no command but patience: Disable voltage, the harmless one, is sent meanwhile.
_TOWARDS: dict[Goal, dict[State, int]] = {
    Goal.ENABLED: {
        State.SWITCH_ON_DISABLED: Control.SHUTDOWN,
        State.READY: Control.SWITCH_ON,
        State.SWITCHED_ON: Control.ENABLE,
        State.ENABLED: Control.ENABLE,
    },
    # Quick stop acts from every state: from a state without power it leads to Switch on disabled.
    Goal.STOPPED: dict.fromkeys(State, Control.QUICK_STOP),
    Goal.DISABLED: dict.fromkeys(State, Control.DISABLE_VOLTAGE),
}

POWER: dict[State, Power] = dict.fromkeys(State, Power.OFF) | {
    State.ENABLED: Power.ON,
    State.QUICK_STOP: Power.STOPPING,
    State.FAULT_REACTION: Power.STOPPING,
    State.FAULT: Power.FAULT,
}
"""What each state means for the motor."""


def decode(statusword: int) -> State:
    """The state that a statusword tells.

    Raises:
        ValueError: the bits fit no state of the standard.
    """
    for mask, value, state in _PATTERNS:
        if statusword & mask == value:
            return state
    raise ValueError(f"statusword 0x{statusword:04X} fits no state of CiA 402")


def controlword(goal: Goal, state: State) -> int:
    """The command that brings a drive from `state` one step nearer to `goal`."""
    return _TOWARDS[goal].get(state, Control.DISABLE_VOLTAGE)
