"""The transports to the drives, one module each, named as `transport` in the rig file.

`Transport` is the interface of a module.
"""

import importlib
from collections.abc import Callable
from typing import Protocol, cast

from drivers.canopen.bus import Tap
from drivers.protocol import Amplifiers, Report
from recordings.rig import Rig

SimulatedTime = Callable[[], int]
"""Present simulated time [ns]."""


class Transport(Protocol):
    """Interface of each module of this folder."""

    def check(self, rig: Rig) -> None:
        """Raise BadInput if the rig cannot work."""

    def describe(self, rig: Rig) -> str:
        """One line of text: bus load, highest rate."""

    def simulated_here(self, rig: Rig) -> bool:
        """Whether the drives are simulated inside this program."""

    def lead(self, rig: Rig) -> float:
        """Time from the beginning of a cycle to its SYNC [s]."""

    def connect(self, rig: Rig, report: Report, tap: Tap, clock: SimulatedTime | None) -> Amplifiers:
        """Connect to the amplifiers without sending anything; `clock` replaces the host's clock with simulated time.

        Raises:
            BadInput: the bus or port does not exist.
        """


def of(rig: Rig) -> Transport:
    """The transport that the rig names."""
    return cast(Transport, importlib.import_module(f"{__name__}.{rig.bus.transport}"))
