"""The power state machine of CiA 402 (IEC 61800-7-201): states, statusword masks and transitions to a goal.

Enabling goes through the states one at a time; no transition to a stop passes through "operation enabled".
"""

from enum import Enum

from drivers.protocol import Goal, Power


class DriveState(Enum):
    """Power states. The value is the text shown to the user."""

    NOT_READY = "not ready to switch on"
    SWITCH_ON_DISABLED = "switch on disabled"
    READY = "ready to switch on"
    SWITCHED_ON = "switched on"
    ENABLED = "operation enabled"
    QUICK_STOP = "quick stop active"
    FAULT_REACTION = "fault reaction active"
    FAULT = "fault"


# Statusword: (mask, value) of each state; bits 0-3, 5, 6 as in the standard's table.
_PATTERNS: tuple[tuple[int, int, DriveState], ...] = (
    (0x4F, 0x00, DriveState.NOT_READY),
    (0x4F, 0x40, DriveState.SWITCH_ON_DISABLED),
    (0x6F, 0x21, DriveState.READY),
    (0x6F, 0x23, DriveState.SWITCHED_ON),
    (0x6F, 0x27, DriveState.ENABLED),
    (0x6F, 0x07, DriveState.QUICK_STOP),
    (0x4F, 0x0F, DriveState.FAULT_REACTION),
    (0x4F, 0x08, DriveState.FAULT),
)

STATUS_BITS: dict[DriveState, int] = {state: value for _, value, state in _PATTERNS}

TARGET_FOLLOWED = 0x1000
"""Statusword bit 12 in the cyclic modes: the drive follows the target."""
LIMIT_ACTIVE = 0x0800
"""Statusword bit 11: a limit of the drive itself holds the axis back."""
FOLLOWING_ERROR = 0x2000
"""Statusword bit 13 in the position modes."""


class Controlword:
    """Controlword commands."""

    DISABLE_VOLTAGE = 0x0000
    QUICK_STOP = 0x0002
    SHUTDOWN = 0x0006
    SWITCH_ON = 0x0007
    ENABLE = 0x000F
    FAULT_RESET = 0x0080


# In a state that is absent here the drive moves on by itself; meanwhile Disable voltage is sent, which is safe.
_TOWARDS: dict[Goal, dict[DriveState, int]] = {
    Goal.ENABLED: {
        DriveState.SWITCH_ON_DISABLED: Controlword.SHUTDOWN,
        DriveState.READY: Controlword.SWITCH_ON,
        DriveState.SWITCHED_ON: Controlword.ENABLE,
        DriveState.ENABLED: Controlword.ENABLE,
    },
    # Quick stop acts from every state: from a state without power it leads to Switch on disabled.
    Goal.STOPPED: dict.fromkeys(DriveState, Controlword.QUICK_STOP),
    Goal.DISABLED: dict.fromkeys(DriveState, Controlword.DISABLE_VOLTAGE),
}

POWER: dict[DriveState, Power] = dict.fromkeys(DriveState, Power.OFF) | {
    DriveState.ENABLED: Power.ON,
    DriveState.QUICK_STOP: Power.STOPPING,
    DriveState.FAULT_REACTION: Power.STOPPING,
    DriveState.FAULT: Power.FAULT,
}
"""Power of the motor in each state."""


def decode(statusword: int) -> DriveState | None:
    """Decode the state from a statusword; None: the bits fit no state of the standard."""
    return next((state for mask, value, state in _PATTERNS if statusword & mask == value), None)


def next_controlword(goal: Goal, state: DriveState | None) -> int:
    """Controlword that takes a drive from `state` one transition towards `goal`; from an unknown state: no power."""
    return Controlword.DISABLE_VOLTAGE if state is None else _TOWARDS[goal].get(state, Controlword.DISABLE_VOLTAGE)
