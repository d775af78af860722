"""Interface of all amplifier drivers; `daq` accesses drives only through it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from recordings.schemas import Level

SIMULATED = "delta-workbench simulated drive"
"""Beginning of the device name of every simulated drive."""
LOCKSTEP_TIMEOUT = 2.0
"""Longest time that an answer may take in lockstep [s], on a quiet machine (see `patience`). Simulated time stands
still meanwhile: only this machine can be late."""

Setpoint = Any
"""Targets of one cycle in the driver's wire format, made by `Amplifiers.encode` before the cycle starts."""

Verdict = Literal["fine", "noted", "accepted", "will be written", "problem", "proved", "consistent", "not shown"]
"""Result of a comparison. noted: worth knowing; accepted: a missing protection that the rig file accepts; proved: by
a reference from outside; consistent: nothing contradicts it; not shown: nothing could have."""

Report = Callable[[Level, str, str], None]
"""Callback for messages to the user: level ("info", "warning", "error"), source, message."""


def unheard(*told: object) -> None:
    """A report that nobody reads, or another callback for what nobody follows."""


class Goal(Enum):
    """Requested state of all drives."""

    ENABLED = "enabled"
    STOPPED = "stopped"
    """Quick stop: every drive decelerates on its own ramp, whatever its target, then switches power off."""
    DISABLED = "disabled"


class Power(Enum):
    """Power state of a drive."""

    OFF = "off"
    """No torque, brake on."""
    ON = "on"
    """Follows the target."""
    STOPPING = "stopping"
    """Decelerates to rest."""
    FAULT = "fault"
    """Switched off because of a fault."""
    UNKNOWN = "unknown"
    """No answer yet, or one that fits no state."""


@dataclass(frozen=True)
class Identity:
    """Identity that a drive reports."""

    joint: int
    """1 ... n, the order of the rig file."""
    address: str
    device: str
    vendor_id: int
    product_code: int
    revision: int | None
    """None: the drive does not tell it."""
    simulated: bool
    lockstep: bool
    """Simulated, and its time advances only with SYNC."""
    serial_number: int = 0
    """0: the drive does not tell it."""
    firmware: str = ""
    """Version of its software; "": not told."""
    position: float | None = None
    """Where the joint stands [rad or m]; None: not known, such as before homing."""
    started: int = 0
    """Number of this start of a simulated drive, which has no other past; 0: real, or it does not tell."""


@dataclass(frozen=True)
class CheckResult:
    """Comparison of one value of a drive with the rig file."""

    where: str
    what: str
    expected: str
    found: str
    verdict: Verdict


@dataclass(frozen=True, slots=True)
class Sample:
    """The drives' answers to one SYNC, one entry per joint; NaN (and statusword 0) where an answer was lost."""

    position: tuple[float, ...]
    """Joint position at the SYNC [rad]."""
    voltage: tuple[float, ...]
    """Signed operating voltage at the SYNC [V]."""
    statusword: tuple[int, ...]
    error_code: tuple[int, ...]
    """Last EMCY code, error or warning; 0: none."""
    power: tuple[Power, ...]
    """Latest known state, also where this cycle's answer was lost."""
    missing: int
    """Number of drives whose answer was lost."""
    trouble: str | None
    """Reason to end the run, naming the joint; None: no error."""
    effort: tuple[float, ...] | None = None
    """Torque actual [N m]; None where the drives do not report it."""
    voltage_stamp: tuple[int, ...] | None = None
    """When each voltage arrived [ns]; None: it was measured at the SYNC. Meaningless where the voltage is NaN."""
    position_stamp: tuple[int, ...] | None = None
    """When each position was measured [ns]: drives on one line are read one after the other."""
    sync: int | None = None
    """Number of the answered SYNC where SYNC does not wait for `exchange`; None: the one just sent."""
    absence: tuple[str, ...] | None = None
    """What is known of each answer that is missing, "" where nothing is; None: nothing of any."""


class Amplifiers(Protocol):
    """All drives of one rig, on one bus. `goal` may be set at any time and takes effect with the next exchange."""

    goal: Goal

    def discover(self) -> tuple[Identity, ...]:
        """Find the drives of the rig, in the order of its joints.

        Raises:
            RunFailed: naming the drives that do not answer.
        """

    def check(self) -> Sequence[CheckResult]:
        """Compare drives and bus with the rig file; writes nothing, moves nothing. Call after `discover`.

        Raises:
            RunFailed: a drive stops answering.
        """

    def configure(self, *, decided: bool = False) -> None:
        """Write the set-up (mode, PDO maps, limits, watchdogs) and read it back; ready for `exchange`.

        `decided`: refuse a drive that states two units of position, of which no small motion has decided one yet.

        Raises:
            RunFailed: a drive refuses, or reads back something else.
            BadInput: a drive does not fit the rig file.
        """

    def encode(self, targets: NDArray[np.float64], torque: NDArray[np.float64] | None = None) -> Sequence[Setpoint]:
        """Joint targets (n, dof) [rad] as n setpoints, with torque offsets (n, dof) [N m] where the rig sends them;
        None: 0."""

    def exchange(self, setpoint: Setpoint | None, timeout: float) -> Sample:
        """Send the targets and a SYNC; collect the answers for at most `timeout` seconds.

        With None, the last measured positions are sent as targets, so that the drives stay where they are, and
        torque offsets of 0.

        Raises:
            RunFailed: the bus is lost.
        """

    def power_off(self) -> tuple[Power, ...]:
        """Switch power off where `exchange` does not reach all drives. Returns the power states found.
        Never raises."""

    def fault_details(self) -> str:
        """What the drives say, without power, of faults that `Sample.trouble` could not name; "": nothing. Never
        raises."""

    def close(self) -> None:
        """Release the drives and leave the bus. Never raises."""
