"""Access to one CAN bus: open, send, receive, and pass every frame to the recorder."""

import os
import socket
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from typing import Any

import can

from drivers.canopen import can_errors
from recordings.buses import CanBus
from recordings.errors import BadInput, RunFailed

Tap = Callable[[int, can.Message, bool], None]
"""Callback for every frame on the bus: time [ns], frame, whether this program sent it."""


def open_bus(settings: CanBus) -> can.BusABC:
    """Open the python-can bus of a rig.

    Raises:
        BadInput: the interface or channel does not exist.
    """
    try:
        bus = can.Bus(**_arguments(settings))
        if settings.interface == "socketcan":
            _enlarge_buffer(bus)
        if settings.interface == "udp_multicast":
            _hear_own_group_only(bus)
        return bus
    # Vendors' libraries raise errors of their own, also while they are loaded.
    except Exception as error:
        raise BadInput(
            f"CAN interface '{settings.interface}' channel '{settings.channel}' cannot be opened: {error}; "
            f"check [bus] in the rig file, that the interface is up{_known(settings.interface)}"
        ) from None


def _arguments(settings: CanBus) -> dict[str, Any]:
    """Arguments of `can.Bus`."""
    # Vendors number their channels.
    channel = int(settings.channel) if settings.channel.isdecimal() else settings.channel
    arguments: dict[str, Any] = {"interface": settings.interface, "channel": channel}
    if settings.interface == "udp_multicast":
        arguments |= {"port": settings.udp_port, "fd": False}
    elif settings.interface not in _WITHOUT_BITRATE:
        arguments["bitrate"] = settings.bitrate
    return arguments | settings.options


def check_interface(settings: CanBus) -> None:
    """Raise BadInput if python-can has no such interface; whether its driver is installed shows when it is opened."""
    names = sorted(can.interfaces.VALID_INTERFACES)
    if settings.interface not in names:
        raise BadInput(f"bus.interface: one of {', '.join(names)} expected, {settings.interface!r} found")


def _known(interface: str) -> str:
    names = sorted(can.interfaces.VALID_INTERFACES)
    return " and its driver installed" if interface in names else f"; python-can has {', '.join(names)}"


def _hear_own_group_only(bus: can.BusABC) -> None:
    """Hear no other group of this port, as a socket of Linux does unless it is told otherwise."""
    with suppress(OSError), socket.socket(fileno=os.dup(bus.fileno())) as same:
        same.setsockopt(socket.IPPROTO_IP, _IP_MULTICAST_ALL, 0)


def _enlarge_buffer(bus: Any) -> None:
    """Enlarge the receive buffer, for frames that arrive while this process is not scheduled; root may exceed the
    system's limit."""
    force = getattr(socket, "SO_RCVBUFFORCE", 33)
    for option in (force, socket.SO_RCVBUF):
        with suppress(OSError):
            bus.socket.setsockopt(socket.SOL_SOCKET, option, _RECEIVE_BUFFER)
            return


def frame_bits(data_bytes: int) -> int:
    """Worst-case length of a standard data frame with stuff bits and interframe space [bit]."""
    return 47 + 8 * data_bytes + (33 + 8 * data_bytes) // 4


_WITHOUT_BITRATE = ("virtual", "socketcan")
"""Interfaces whose bit rate is none, or is set outside."""
_IP_MULTICAST_ALL = 49
"""Socket option of Linux (linux/in.h), which the socket module does not name."""
_CLOCK_TOLERANCE = 1.0
"""Difference to the host's clock up to which a time stamp is of that clock: adapters count from their start [s]."""
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
        from can.interfaces.socketcan import SocketcanBus
        from can.interfaces.udp_multicast import UdpMulticastBus

        self._bus = bus
        self.controller = partial(can_errors.controller, bus)
        """State of the CAN controller, where it is not error-active."""
        # On socketcan, other programs of this host send such frames, too.
        self._marks_own = not isinstance(bus, SocketcanBus)
        # Only this interface returns sent frames to their sender without a mark.
        echoes = isinstance(bus, UdpMulticastBus)
        self._expected_echoes: deque[tuple[int, bytes]] | None = deque(maxlen=_MAX_ECHOES) if echoes else None
        self._unreadable = 0
        self.echoes = self.received = self.stamped = 0
        """Frames of our own that came back; those of others, and how many of these had a time of the host's clock."""
        self.arrival = 0
        """When the last frame arrived [ns]."""
        self.bits = 0
        """Bits of all frames so far, in the worst case."""
        self.tap: Tap | None = None
        self.clock: Callable[[], int] | None = None
        """Simulated time [ns]; None: the host's clock."""
        self.on_error_frame: Callable[[can.Message], None] | None = None
        self.cyclic: dict[int, Callable[[float, bool], None]] = {}
        """Callbacks for frames that the kernel sends for this program, by arbitration id; arguments: time [s since
        the epoch], whether it came from another node."""

    def send(self, arbitration_id: int, data: bytes | None) -> None:
        """Send one frame; without data a remote frame, which asks for the frame with that id (node guarding).

        Raises:
            RunFailed: the bus does not accept it.
        """
        dlc, remote = (1, True) if data is None else (len(data), False)
        message = can.Message(
            arbitration_id=arbitration_id, data=data, dlc=dlc, is_remote_frame=remote, is_extended_id=False
        )
        if self._expected_echoes is not None:
            self._expected_echoes.append((message.arbitration_id, bytes(message.data)))
        self.bits += frame_bits(message.dlc)
        if self.tap is not None:
            self.tap(self.now(), message, True)
        try:
            self._bus.send(message)
        except (can.CanError, OSError) as error:
            raise RunFailed(can_errors.explain(self._bus, error, "the CAN bus does not accept frames")) from None

    def receive(self, timeout: float) -> tuple[int, bytes] | None:
        """The next standard data frame (arbitration id, data) within `timeout` seconds, or None.

        Raises:
            RunFailed: the bus is lost.
        """
        deadline = time.perf_counter() + timeout
        while (message := self._receive_message(deadline)) is not None:
            if self._is_echo(message):
                self.echoes += 1
                continue
            self.arrival = self._arrival(message)
            self.received += 1
            self.bits += frame_bits(message.dlc)
            on_cyclic = self.cyclic.get(message.arbitration_id)
            if self.tap is not None:
                self.tap(self.arrival, message, on_cyclic is not None and not message.is_rx)
            if on_cyclic is not None:
                on_cyclic(message.timestamp, message.is_rx)
            if message.is_error_frame and self.on_error_frame is not None:
                self.on_error_frame(message)
            if not (message.is_extended_id or message.is_remote_frame or message.is_error_frame):
                return message.arbitration_id, bytes(message.data)
        return None

    def frames(self, duration: float) -> Iterator[tuple[int, bytes]]:
        """What `receive` gives within `duration` [s]; with 0, what has arrived already. Raises as `receive`."""
        deadline = time.perf_counter() + duration
        while (frame := self.receive(deadline - time.perf_counter())) is not None:
            yield frame

    def _receive_message(self, deadline: float) -> can.Message | None:
        while True:
            try:
                return self._bus.recv(max(0.0, deadline - time.perf_counter()))
            except (can.CanError, OSError) as error:
                # On udp_multicast a datagram of another program may be no frame.
                no_frame = isinstance(error, can.CanOperationError) and self._expected_echoes is not None
                self._unreadable += 1
                if not no_frame or self._unreadable > _MAX_UNREADABLE:
                    raise RunFailed(can_errors.explain(self._bus, error, "the CAN bus is lost")) from None

    def _arrival(self, message: can.Message) -> int:
        """When a frame arrived [ns]: its time stamp where this is of the host's clock.

        One stamp that fits shows whose clock it is. A later one may be old: this program stood still and reads only
        now; with the time of reading, the frame would come behind those that arrived after it.
        """
        if self.clock is not None:
            return self.clock()
        now = time.time()
        if not self.stamped and abs(message.timestamp - now) > _CLOCK_TOLERANCE:
            return round(now * 1e9)
        self.stamped += 1
        return round(message.timestamp * 1e9)

    def _is_echo(self, message: can.Message) -> bool:
        if self._marks_own and not message.is_rx:
            return True
        key = (message.arbitration_id, bytes(message.data))
        if not self._expected_echoes or key not in self._expected_echoes:
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
