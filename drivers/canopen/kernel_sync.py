"""SYNC sent by the kernel: SocketCAN's broadcast manager (BCM) sends it, however busy this program is.

The kernel counts every period from the moment at which it got round to the frame before, so on its own it would run
slow by some microseconds per SYNC. Its period is therefore adjusted after every SYNC, by the kernel's own time stamp
of it. The socket belongs to this process: if it dies, SYNC ends.
"""

import socket
import struct
import time
from collections.abc import Callable

from drivers.canopen.bus import Link
from drivers.canopen.setup import SYNC_ID
from recordings.errors import BadInput, RunFailed

LEAD = 0.3
"""Share of the period by which the targets are sent before their SYNC."""

# struct bcm_msg_head (linux/can/bcm.h) with two struct bcm_timeval: first interval, period; then struct can_frame.
_HEAD = struct.Struct("@IIIllllII")
_SYNC_FRAME = struct.pack("=IB3x8s", SYNC_ID, 0, b"")
_PROPORTIONAL, _INTEGRAL = 0.2, 0.02
_MOST = 0.1
"""Share of the period by which one period may be shortened or prolonged."""


class Pacer:
    """Numbers SYNCs by the time they were sent, and tells how long the next period must be to stay on time."""

    def __init__(self, period: float, first: float) -> None:
        """`period` [s]; `first`: when SYNC 0 is due [s]."""
        self._period = period
        self._first = first
        self._bias = 0.0

    def on_sync(self, sent: float) -> tuple[int, float]:
        """Number of the SYNC sent at that time [s], and the period to set [s]."""
        number = max(0, round((sent - self._first) / self._period))
        late = sent - (self._first + number * self._period)
        self._bias += _INTEGRAL * late
        change = self._bias + _PROPORTIONAL * late
        most = _MOST * self._period
        return number, self._period - min(max(change, -most), most)


class KernelSync:
    """SYNC on the SocketCAN interface `channel`, seen through `link`; begins with the first `wait`."""

    def __init__(self, link: Link, channel: str, period: float) -> None:
        """`period` [s].

        Raises:
            BadInput: the kernel has no broadcast manager, or not this interface.
        """
        self._link = link
        self._period = period
        self._pacer: Pacer | None = None
        self._set = 0
        self._number = -1
        try:
            self._socket = socket.socket(socket.AF_CAN, socket.SOCK_DGRAM, socket.CAN_BCM)
            self._socket.connect((channel,))
        except (AttributeError, OSError) as error:
            raise BadInput(
                f"the kernel does not time SYNC on '{channel}': {error}; set bus.sync = \"host\""
            ) from None
        link.cyclic[SYNC_ID] = self._on_sync

    def wait(self, dispatch: Callable[[int, bytes], None], timeout: float) -> int | None:
        """Until the next SYNC is on the bus; returns its number, from 0 and by its time, or None after `timeout` [s].

        Whatever else arrives meanwhile goes to `dispatch`.

        Raises:
            RunFailed: the bus is lost.
        """
        deadline = time.perf_counter() + timeout
        if self._pacer is None:
            self._start(dispatch)
        before = self._number
        while self._number == before:
            frame = self._link.receive(max(0.0, deadline - time.perf_counter()))
            if frame is None:
                return None
            if frame[0] != SYNC_ID:
                dispatch(*frame)
        return self._number

    def _start(self, dispatch: Callable[[int, bytes], None]) -> None:
        first = time.perf_counter() + LEAD * self._period
        while (remaining := first - time.perf_counter()) > 0:
            frame = self._link.receive(remaining)
            if frame is not None:
                dispatch(*frame)
        self._pacer = Pacer(self._period, first)
        # The kernel sends the first frame at once.
        self._order(self._period, socket.CAN_BCM_SETTIMER | socket.CAN_BCM_STARTTIMER)

    def _on_sync(self, stamp: float) -> None:
        if self._pacer is None:
            return
        # The stamp is wall clock time, which may be set meanwhile.
        sent = stamp - (time.time() - time.perf_counter())
        self._number, period = self._pacer.on_sync(sent)
        self._order(period, socket.CAN_BCM_SETTIMER)

    def _order(self, period: float, flags: int) -> None:
        microseconds = round(period * 1e6)
        if microseconds == self._set:
            return
        self._set = microseconds
        seconds, rest = divmod(microseconds, 1_000_000)
        head = _HEAD.pack(socket.CAN_BCM_TX_SETUP, flags, 0, 0, 0, seconds, rest, SYNC_ID, 1)
        try:
            self._socket.send(head + _SYNC_FRAME)
        except OSError as error:
            raise RunFailed(f"the kernel does not send SYNC: {error}") from None

    def close(self) -> None:
        """No more SYNC. One that is still to be received sets no further period."""
        self._pacer = None
        self._socket.close()
