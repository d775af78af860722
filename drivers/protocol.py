"""What every amplifier driver offers; `daq` knows drives only through this."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True)
class Identity:
    """One drive as it presents itself."""

    joint: int
    """1 ... n, the order of the rig file."""
    node_id: int
    device: str
    vendor_id: int
    product_code: int
    revision: int


@dataclass(frozen=True)
class Sample:
    """The drives' answers to one SYNC, one entry per joint; NaN (and statusword 0) where an answer was lost."""

    position: tuple[float, ...]
    """Joint position at the SYNC [rad]."""
    voltage: tuple[float, ...]
    """Signed operating voltage at the SYNC [V]."""
    effort: tuple[float, ...] | None
    """Torque actual [N m]; None where the drives do not report it in the cycle."""
    statusword: tuple[int, ...]
    error_code: tuple[int, ...]
    """Last EMCY error code; 0: none."""

    @property
    def missing(self) -> int:
        """Number of drives whose answer was lost."""
        return sum(position != position for position in self.position)


class Amplifiers(Protocol):
    """All drives of one rig, on one bus. The order of calls is the order of the methods."""

    def discover(self) -> tuple[Identity, ...]:
        """Find the drives of the rig. Raises RunFailed naming the drives that do not answer."""
        ...

    def configure(self) -> None:
        """Write the set-up (mode, PDO maps, limits, watchdogs) and read it back. Raises RunFailed on a difference."""
        ...

    def measure(self) -> tuple[float, ...]:
        """Joint positions [rad] while the drives are not enabled."""
        ...

    def enable(self) -> None:
        """Bring all drives to Operation enabled, their targets at the measured position. Raises RunFailed."""
        ...

    def exchange(self, target: Sequence[float], timeout: float) -> Sample:
        """Send the joint targets [rad] and a SYNC; collect the answers for at most `timeout` seconds."""
        ...

    def quick_stop(self) -> None:
        """Every drive stops on its own ramp at once, whatever was commanded. Never raises."""
        ...

    def disable(self) -> bool:
        """Take the power from all drives, brakes on; True when every drive has confirmed it. Never raises."""
        ...

    def close(self) -> None:
        """Leave the bus. Never raises."""
        ...
