"""The ways to reach drives, one module each, named as `transport` in the rig file.

What a module offers is written down in `Transport`.
"""

import importlib
from collections.abc import Callable
from typing import Protocol, cast

import can

from drivers.protocol import Amplifiers, Report
from recordings.rig import Rig

Tap = Callable[[int, can.Message, bool], None]
"""Called for every CAN frame, if there are any: time [ns], the frame, sent by us?"""
Clock = Callable[[], int]
"""Simulated time [ns]."""


class Transport(Protocol):
    """What each module of this folder is."""

    def check(self, rig: Rig) -> None:
        """Raise BadInput where the rig cannot work."""
        ...

    def describe(self, rig: Rig) -> str:
        """One line for a person: load, highest safe rate."""
        ...

    def simulated_here(self, rig: Rig) -> bool:
        """Whether the drives are to be simulated inside this program."""
        ...

    def lead(self, rig: Rig) -> float:
        """By how much a cycle begins before its SYNC [s]."""
        ...

    def connect(self, rig: Rig, report: Report, tap: Tap, clock: Clock | None) -> Amplifiers:
        """The amplifiers, not yet spoken to; `clock` stamps in place of the host's where time is simulated.

        Raises:
            BadInput: the bus or port does not exist.
        """
        ...


def of(rig: Rig) -> Transport:
    """The transport that the rig names."""
    return cast(Transport, importlib.import_module(f"{__name__}.{rig.bus.transport}"))
