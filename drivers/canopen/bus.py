"""Access to one CAN bus: open, send, receive, and pass every frame to the recorder."""

import socket
import time
from collections import deque
from collections.abc import Callable
from typing import Any

import can

from recordings.buses import CanBus
from recordings.errors import BadInput, RunFailed

Tap = Callable[[int, can.Message, bool], None]
"""Callback for every frame on the bus: time [ns], frame, whether this program sent it."""


def open_bus(settings: CanBus) -> can.BusABC:
    """Open the python-can bus of a rig.

    Raises:
        BadInput: the interface or channel does not exist.
    """
    arguments: dict[str, Any] = {"interface": settings.interface, "channel": settings.channel}
    if settings.interface == "udp_multicast":
        arguments |= {"port": settings.port, "fd": False}
    try:
        bus = can.Bus(**arguments)
        if settings.interface == "socketcan":
            _enlarge_buffer(bus)
        return bus
    except (can.CanError, OSError, ValueError) as error:
        raise BadInput(
            f"CAN interface '{settings.interface}' channel '{settings.channel}' cannot be opened: {error}; "
            "check [bus] in the rig file and that the interface is up"
        ) from None


def _enlarge_buffer(bus: Any) -> None:
    """Enlarge the receive buffer, for frames that arrive while this process is not scheduled; root may exceed the
    system's limit."""
    force = getattr(socket, "SO_RCVBUFFORCE", 33)
    for option in (force, socket.SO_RCVBUF):
        try:
            bus.socket.setsockopt(socket.SOL_SOCKET, option, _RECEIVE_BUFFER)
            return
        except OSError:
            continue


def frame_bits(data_bytes: int) -> int:
    """Worst-case length of a standard data frame with stuff bits and interframe space [bit]."""
    return 47 + 8 * data_bytes + (33 + 8 * data_bytes) // 4


_RECEIVE_BUFFER = 2**23
"""[bytes]; a frame takes several hundred bytes."""
_MAX_ECHOES = 1000
"""Number of sent frames that are remembered until their echo arrives."""
_MAX_UNREADABLE = 1000
"""Number of datagrams that are no frames after which the bus counts as lost."""


class Link:
    """Access of one participant to a CAN bus; single-threaded.

    `clock` gives the time stamp [ns] of what is sent and received: the host's clock, or simulated time in lockstep.
    """

    def __init__(self, bus: can.BusABC) -> None:
        from can.interfaces.udp_multicast import UdpMulticastBus

        self._bus = bus
        # Only this interface returns sent frames to their sender.
        echoes = isinstance(bus, UdpMulticastBus)
        self._expected_echoes: deque[tuple[int, bytes]] | None = deque(maxlen=_MAX_ECHOES) if echoes else None
        self._unreadable = 0
        self.tap: Tap | None = None
        self.clock: Callable[[], int] | None = None
        """Simulated time [ns]; None: the host's clock."""
        self.on_error_frame: Callable[[can.Message], None] | None = None
        self.cyclic: dict[int, Callable[[float], None]] = {}
        """Callbacks for frames that the kernel sends for this program, by arbitration id; argument: time [s since the
        epoch]."""

    def send(self, arbitration_id: int, data: bytes) -> None:
        """Send one frame.

        Raises:
            RunFailed: the bus does not accept it.
        """
        self._send(can.Message(arbitration_id=arbitration_id, data=data, is_extended_id=False, check=False))

    def send_remote(self, arbitration_id: int) -> None:
        """Send a remote frame, which asks for the frame with that id (node guarding).

        Raises:
            RunFailed: the bus does not accept it.
        """
        self._send(can.Message(arbitration_id=arbitration_id, dlc=1, is_remote_frame=True, is_extended_id=False))

    def _send(self, message: can.Message) -> None:
        if self._expected_echoes is not None:
            self._expected_echoes.append((message.arbitration_id, bytes(message.data)))
        if self.tap is not None:
            self.tap(self.now(), message, True)
        try:
            self._bus.send(message)
        except (can.CanError, OSError) as error:
            raise RunFailed(f"the CAN bus does not accept frames: {error}") from None

    def receive(self, timeout: float) -> tuple[int, bytes] | None:
        """The next standard data frame (arbitration id, data) within `timeout` seconds, or None.

        Raises:
            RunFailed: the bus is lost.
        """
        deadline = time.perf_counter() + timeout
        while (message := self._receive_message(deadline)) is not None:
            if self._is_echo(message):
                continue
            on_sent = None if message.is_rx else self.cyclic.get(message.arbitration_id)
            if self.tap is not None:
                arrival = round(message.timestamp * 1e9) if self.clock is None else self.clock()
                self.tap(arrival, message, on_sent is not None)
            if on_sent is not None:
                on_sent(message.timestamp)
            if message.is_error_frame and self.on_error_frame is not None:
                self.on_error_frame(message)
            if not (message.is_extended_id or message.is_remote_frame or message.is_error_frame):
                return message.arbitration_id, bytes(message.data)
        return None

    def _receive_message(self, deadline: float) -> can.Message | None:
        while True:
            try:
                return self._bus.recv(max(0.0, deadline - time.perf_counter()))
            except can.CanOperationError as error:
                # On udp_multicast a datagram of another program may be no frame.
                self._unreadable += 1
                if self._unreadable > _MAX_UNREADABLE or self._expected_echoes is None:
                    raise RunFailed(f"the CAN bus is lost: {error}") from None
            except (can.CanError, OSError) as error:
                raise RunFailed(f"the CAN bus is lost: {error}") from None

    def _is_echo(self, message: can.Message) -> bool:
        if not self._expected_echoes:
            return False
        key = (message.arbitration_id, bytes(message.data))
        if key not in self._expected_echoes:
            return False
        # Echoes come in the order of sending; those before this one were lost.
        while self._expected_echoes.popleft() != key:
            pass
        return True

    def now(self) -> int:
        """Present time [ns]."""
        return time.time_ns() if self.clock is None else self.clock()

    def close(self) -> None:
        """Leave the bus."""
        self._bus.shutdown()
