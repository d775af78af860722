"""What every amplifier driver offers; `daq` knows drives only through this."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from recordings.schemas import Level

Setpoint = Any
"""One cycle's targets in the driver's own wire format, made by `Amplifiers.encode` before the cycle starts."""

Report = Callable[[Level, str, str], None]
"""Called with what a person should know: level ("info", "warning", "error"), source, message."""


class Goal(Enum):
    """What is wanted of all drives."""

    ENABLED = "enabled"
    STOPPED = "stopped"
    """Quick stop: every drive brings itself to rest on its own ramp, whatever is commanded, then takes power off."""
    DISABLED = "disabled"


class Power(Enum):
    """What a drive does with its motor."""

    OFF = "off"
    """No torque, brake on."""
    ON = "on"
    """Follows the target."""
    STOPPING = "stopping"
    """Brings itself to rest."""
    FAULT = "fault"
    """Switched itself off because of a fault."""
    UNKNOWN = "unknown"
    """Nothing heard yet, or an answer that fits no state."""


@dataclass(frozen=True)
class Identity:
    """One drive as it presents itself."""

    joint: int
    """1 ... n, the order of the rig file."""
    address: str
    device: str
    vendor_id: int
    product_code: int
    revision: int
    simulated: bool
    lockstep: bool
    """Simulated, and its time advances only with SYNC."""


@dataclass(frozen=True)
class CheckResult:
    """One thing that was compared with the rig file."""

    where: str
    what: str
    expected: str
    found: str
    verdict: Literal["fine", "will be written", "problem"]


@dataclass(frozen=True, slots=True)
class Sample:
    """The drives' answers to one SYNC, one entry per joint; NaN (and statusword 0) where an answer was lost."""

    position: tuple[float, ...]
    """Joint position at the SYNC [rad]."""
    voltage: tuple[float, ...]
    """Signed operating voltage at the SYNC [V]."""
    statusword: tuple[int, ...]
    error_code: tuple[int, ...]
    """Last EMCY error code; 0: none."""
    power: tuple[Power, ...]
    """Latest known state, also where this cycle's answer was lost."""
    missing: int
    """Number of drives whose answer was lost."""
    trouble: str | None
    """Why the run cannot go on, naming the joint; None: all is well."""
    effort: tuple[float, ...] | None = None
    """Torque actual [N m]; None where the drives do not report it."""
    voltage_stamp: tuple[int, ...] | None = None
    """When each voltage arrived [ns]; None: it was measured at the SYNC. Meaningless where the voltage is NaN."""
    position_stamp: tuple[int, ...] | None = None
    """Likewise of the positions: drives on one line are read one after the other."""
    sync: int | None = None
    """Where SYNC does not wait for `exchange`: number of the one that was answered; None: the one just sent."""


class Amplifiers(Protocol):
    """All drives of one rig, on one bus. `goal` may be set at any time and takes effect with the next exchange."""

    goal: Goal

    def discover(self) -> tuple[Identity, ...]:
        """Find the drives of the rig, in the order of its joints.

        Raises:
            RunFailed: naming the drives that do not answer.
        """
        ...

    def check(self) -> Sequence[CheckResult]:
        """Compare drives and bus with the rig file; writes nothing, moves nothing. After `discover`.

        Raises:
            RunFailed: a drive stops answering.
        """
        ...

    def configure(self) -> None:
        """Write the set-up (mode, PDO maps, limits, watchdogs) and read it back; ready for `exchange`.

        Raises:
            RunFailed: a drive refuses, or reads back something else.
        """
        ...

    def encode(self, targets: NDArray[np.float64]) -> Sequence[Setpoint]:
        """Joint targets (n, dof) [rad] as n setpoints."""
        ...

    def exchange(self, setpoint: Setpoint | None, timeout: float) -> Sample:
        """Send the targets and a SYNC; collect the answers for at most `timeout` seconds.

        With None, the targets of the last answer are sent back: the drive is told to stay where it is.

        Raises:
            RunFailed: the bus is lost.
        """
        ...

    def power_off(self) -> tuple[Power, ...]:
        """Take the power by whatever way is left where `exchange` does not reach all drives; the powers it found.
        Never raises."""
        ...

    def close(self) -> None:
        """Release the drives and leave the bus. Never raises."""
        ...
