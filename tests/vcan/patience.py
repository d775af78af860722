"""What makes `daq` wait where it would give up: a silence here means a machine that stalls, not a drive that is lost.

The programs import this before they begin. Whatever they do meanwhile is what they always do.
"""

from canopen.sdo import SdoClient

from daq import listen, stream
from daq.clock import LockstepClock
from drivers.canopen import drive as canopen_drive
from drivers.canopen import setup as canopen_setup

STALL = 20.0
"""No machine is expected to stand still for so long [s]."""


def of_recorder(answer_timeout: float) -> None:
    """For `daq record`; in lockstep a drive that falls silent for good takes `answer_timeout` [s] in every cycle."""
    LockstepClock.answer_timeout = answer_timeout
    SdoClient.RESPONSE_TIMEOUT = STALL
    stream._POWER_TIMEOUT = STALL
    canopen_drive._HEARTBEAT_TIMEOUT = STALL
    canopen_setup.MASTER_TIMEOUT_MS = round(1000 * STALL)
    listen.SILENCE = STALL


def of_simulation() -> None:
    """For `daq sim`, which also gets by with a fifth of its computing time: nobody looks at how the machine moves."""
    import mujoco

    from drivers.simulated import machine

    # MuJoCo's own timers read the clock, which takes longer in User-mode Linux than a step of the plant.
    mujoco.set_mjcb_time(float)
    machine.MAX_STEP = 1e-3
