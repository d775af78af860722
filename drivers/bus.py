"""One CAN bus as the drivers use it: open, send, receive, and show every frame to whoever records."""

import time
from collections.abc import Callable
from typing import Any

import can

from recordings.buses import CanBus
from recordings.errors import BadInput, RunFailed

Tap = Callable[[int, can.Message, bool], None]
"""Called for every frame on the bus: time [ns], the frame, sent by us?"""


def open_bus(settings: CanBus) -> can.BusABC:
    """Open the python-can bus of a rig.

    Raises:
        BadInput: the interface or channel does not exist on this machine.
    """
    arguments: dict[str, Any] = {"interface": settings.interface, "channel": settings.channel}
    if settings.interface == "udp_multicast":
        arguments |= {"port": settings.port, "fd": False}
    try:
        return can.Bus(**arguments)
    except (can.CanError, OSError, ValueError) as error:
        raise BadInput(
            f"CAN interface '{settings.interface}' channel '{settings.channel}' cannot be opened: {error}; "
            "check [bus] in the rig file and that the interface is up"
        ) from None


def frame_bits(data_bytes: int) -> int:
    """Worst-case length of a standard data frame with stuff bits and interframe space [bit]."""
    return 47 + 8 * data_bytes + (33 + 8 * data_bytes) // 4


class Link:
    """A CAN bus seen by one participant; single-threaded.

    `clock` gives the time stamp [ns] of what is sent and received: the host's clock, or simulated time in lockstep.
    """

    def __init__(self, bus: can.BusABC, *, own_ids: Callable[[int], bool]) -> None:
        """`own_ids` tells which arbitration ids only we send: on udp_multicast they come back as echoes."""
        self._bus = bus
        self._own_ids = own_ids
        self.tap: Tap | None = None
        self.clock: Callable[[], int] | None = None
        """Simulated time [ns]; None: the host's clock."""
        self.on_error_frame: Callable[[can.Message], None] | None = None

    def send(self, arbitration_id: int, data: bytes) -> None:
        """Send one frame.

        Raises:
            RunFailed: the bus does not take it.
        """
        message = can.Message(arbitration_id=arbitration_id, data=data, is_extended_id=False, check=False)
        if self.tap is not None:
            self.tap(self.now(), message, True)
        try:
            self._bus.send(message)
        except (can.CanError, OSError) as error:
            raise RunFailed(f"the CAN bus does not take frames: {error}") from None

    def receive(self, timeout: float) -> tuple[int, bytes] | None:
        """The next standard data frame (arbitration id, data) within `timeout` seconds, or None.

        Raises:
            RunFailed: the bus is lost.
        """
        deadline = time.perf_counter() + timeout
        while True:
            remaining = deadline - time.perf_counter()
            try:
                message = self._bus.recv(max(0.0, remaining))
            except (can.CanError, OSError) as error:
                raise RunFailed(f"the CAN bus is lost: {error}") from None
            if message is None:
                return None
            if self._own_ids(message.arbitration_id) and not message.is_extended_id:
                continue
            if self.tap is not None:
                arrival = round(message.timestamp * 1e9) if self.clock is None else self.clock()
                self.tap(arrival, message, False)
            if message.is_error_frame and self.on_error_frame is not None:
                self.on_error_frame(message)
            if not (message.is_extended_id or message.is_remote_frame or message.is_error_frame):
                return message.arbitration_id, bytes(message.data)

    def now(self) -> int:
        """Present time [ns]."""
        return time.time_ns() if self.clock is None else self.clock()

    def close(self) -> None:
        """Leave the bus."""
        self._bus.shutdown()
