"""Reading voltages by SDO beside the cycle, for drives that cannot map theirs into a PDO."""

import struct
from collections.abc import Sequence

from drivers.canopen.axis import CanopenAxis
from drivers.canopen.bus import Link

_GIVE_UP = 50
"""Cycles after which an unanswered request is forgotten."""
_UPLOAD = struct.Struct("<BHB4x")
_ANSWER = struct.Struct("<BHBh2x")


class VoltagePoll:
    """One request under way at a time, round and round the drives; the cycle never waits for an answer."""

    def __init__(self, axes: Sequence[CanopenAxis], link: Link) -> None:
        self.axes = axes
        self._link = link
        self._next = 0
        self._asked: CanopenAxis | None = None
        self._since = 0

    def request(self, cycle: int) -> None:
        """Ask the next drive, unless the last one has yet to answer."""
        if not self.axes or (self._asked is not None and cycle - self._since < _GIVE_UP):
            return
        self._asked = self.axes[self._next % len(self.axes)]
        self._next += 1
        self._since = cycle
        voltage = self._asked.drive.voltage
        self._link.send(0x600 + self._asked.drive.node_id, _UPLOAD.pack(0x40, voltage.index, voltage.sub))

    def take_response(self, axis: CanopenAxis, data: bytes) -> None:
        """An SDO response of `axis`, if it is the one that is waited for; an abort ends the wait."""
        if axis is not self._asked or len(data) != _ANSWER.size:
            return
        command, index, sub, raw = _ANSWER.unpack(data)
        if (index, sub) != (axis.drive.voltage.index, axis.drive.voltage.sub):
            return
        self._asked = None
        if command & 0xE0 == 0x40:
            axis.take_polled_voltage(raw, self._link.now())
