"""SYNC sent by the kernel: SocketCAN's broadcast manager (BCM) sends it at any load of this program.

The kernel counts every period from the time at which it sent the previous frame, so SYNC would be late by some more
microseconds each time. A phase-locked loop therefore adjusts the period after every SYNC, by the kernel's time stamp.
The socket belongs to this process: SYNC ends with it.
"""

import math
import socket
import struct
import time
from collections.abc import Callable

from drivers.canopen.bus import Link
from drivers.canopen.requirements import SYNC_ID
from drivers.protocol import unheard
from recordings.errors import BadInput, RunFailed

LEAD = 0.3
"""Time by which the targets are sent before their SYNC, as a fraction of the period."""

# struct bcm_msg_head (linux/can/bcm.h) with two struct bcm_timeval: first interval, period; then struct can_frame.
_HEAD = struct.Struct("@IIIllllII")
_SYNC_FRAME = struct.pack("=IB3x8s", SYNC_ID, 0, b"")
_PROPORTIONAL, _INTEGRAL = 0.2, 0.02
_MAX_CORRECTION = 0.1
"""Greatest correction of one period, as a fraction of it."""

_LEAST_PERIOD = 0.5
"""Fraction of the period between two SYNCs below which the kernel sent only one of them."""


class Pacer:
    """PI phase-locked loop: numbers SYNCs by the time they were sent, and computes the next period."""

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
        limit = _MAX_CORRECTION * self._period
        return number, self._period - min(max(change, -limit), limit)


class KernelSync:
    """SYNC on the SocketCAN interface `channel`, received through `link`; begins with the first `wait`."""

    def __init__(self, link: Link, channel: str, period: float) -> None:
        """`period` [s].

        Raises:
            BadInput: the kernel has no broadcast manager, or the interface does not exist.
        """
        self._link = link
        self._period = period
        self._pacer: Pacer | None = None
        self._period_us = 0
        self._number = -1
        self._stamp = -math.inf
        self.on_sync: Callable[[bool], None] = unheard
        """Called with each SYNC, before the answers to it, also where the host is late: whether it is of another
        master."""
        try:
            self._socket = socket.socket(socket.AF_CAN, socket.SOCK_DGRAM, socket.CAN_BCM)
            self._socket.connect((channel,))
        except (AttributeError, OSError) as error:
            raise BadInput(f"the kernel cannot send SYNC on '{channel}': {error}; set bus.sync = \"host\"") from None
        link.cyclic[SYNC_ID] = self._on_sync_frame

    def wait(self, dispatch: Callable[[int, bytes], None], timeout: float) -> int | None:
        """Wait for the next SYNC; returns its number, from 0 and by its time, or None after `timeout` [s].

        Other frames go to `dispatch`.

        Raises:
            RunFailed: the bus is lost.
        """
        deadline = time.perf_counter() + timeout
        if self._pacer is None:
            self._start(dispatch)
        before = self._number
        for frame in self._link.frames(deadline - time.perf_counter()):
            if frame[0] != SYNC_ID:
                dispatch(*frame)
            if self._number != before:
                return self._number
        return None

    def _start(self, dispatch: Callable[[int, bytes], None]) -> None:
        first = time.perf_counter() + LEAD * self._period
        for frame in self._link.frames(LEAD * self._period):
            dispatch(*frame)
        self._pacer = Pacer(self._period, first)
        # The kernel sends the first frame immediately.
        self._set_period(self._period, socket.CAN_BCM_SETTIMER | socket.CAN_BCM_STARTTIMER)

    def _on_sync_frame(self, stamp: float, received: bool) -> None:
        # Frames of other programs of this host are marked as those of the kernel's timer are.
        foreign = received or stamp - self._stamp < _LEAST_PERIOD * self._period
        if self._pacer is not None and not received:
            self._stamp = stamp
            # The stamp is wall clock time, which may be adjusted meanwhile.
            sent = stamp - (time.time() - time.perf_counter())
            self._number, period = self._pacer.on_sync(sent)
            self._set_period(period, socket.CAN_BCM_SETTIMER)
        self.on_sync(foreign)

    def _set_period(self, period: float, flags: int) -> None:
        microseconds = round(period * 1e6)
        if microseconds == self._period_us:
            return
        self._period_us = microseconds
        seconds, remainder_us = divmod(microseconds, 1_000_000)
        head = _HEAD.pack(socket.CAN_BCM_TX_SETUP, flags, 0, 0, 0, seconds, remainder_us, SYNC_ID, 1)
        try:
            self._socket.send(head + _SYNC_FRAME)
        except OSError as error:
            raise RunFailed(f"the kernel does not send SYNC: {error}") from None

    def close(self) -> None:
        """Stop SYNC. A SYNC that is received later sets no period."""
        self._pacer = None
        self._socket.close()
