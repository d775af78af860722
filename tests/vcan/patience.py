"""Longer timeouts for `daq`: a missing answer here means a computer that stalls, not a drive that is lost.

The programs import this module before they start; only their timeouts change.
"""

from canopen.sdo import SdoClient

from daq.cycle import stream
from daq.cycle.clock import LockstepClock
from daq.passive import listen
from drivers.canopen import drive as canopen_drive
from drivers.canopen import requirements

STALL = 20.0
"""Longest stall of the computer that is expected [s]."""


def of_recorder() -> None:
    """Timeouts of `daq record`."""
    LockstepClock.answer_timeout = STALL
    SdoClient.RESPONSE_TIMEOUT = STALL
    stream._POWER_TIMEOUT = STALL
    canopen_drive._HEARTBEAT_TIMEOUT = STALL
    requirements.MASTER_TIMEOUT_MS = round(1000 * STALL)
    listen.SYNC_TIMEOUT = STALL


def of_simulation() -> None:
    """Timeouts of `daq sim`, with a fifth of its computing time: the tests do not depend on the motion's accuracy."""
    import mujoco

    from drivers.simulated import machine

    # MuJoCo's own timers read the clock, which takes longer in User-mode Linux than a step of the plant.
    mujoco.set_mjcb_time(float)
    machine.MAX_STEP = 1e-3
