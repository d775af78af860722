"""Read voltages by SDO, for drives that cannot map them into a PDO."""

import struct
from collections.abc import Sequence

from drivers.canopen.axis import CanopenAxis
from drivers.canopen.bus import Link
from drivers.canopen.pdo import voltage_is_signed

_REQUEST_TIMEOUT = 50
"""Number of cycles after which an unanswered request is dropped."""
_UPLOAD = struct.Struct("<BHB4x")
_RESPONSE = struct.Struct("<BHB4s")


class VoltagePoll:
    """Polls the drives in turn, one pending request at a time; the cycle never waits for a response."""

    def __init__(self, axes: Sequence[CanopenAxis], link: Link) -> None:
        self.axes = axes
        self._link = link
        self._next = 0
        self._pending: CanopenAxis | None = None
        self._request_cycle = 0

    def request(self, cycle: int) -> None:
        """Send a request to the next drive, unless one is pending."""
        if not self.axes or (self._pending is not None and cycle - self._request_cycle < _REQUEST_TIMEOUT):
            return
        self._pending = self.axes[self._next % len(self.axes)]
        self._next += 1
        self._request_cycle = cycle
        voltage = self._pending.drive.voltage
        self._link.send(0x600 + self._pending.drive.node_id, _UPLOAD.pack(0x40, voltage.index, voltage.sub))

    def take_response(self, axis: CanopenAxis, data: bytes) -> None:
        """Process an SDO response of `axis` if it answers the pending request; an abort ends the request."""
        if axis is not self._pending or len(data) != _RESPONSE.size:
            return
        command, index, sub, value = _RESPONSE.unpack(data)
        if (index, sub) != (axis.drive.voltage.index, axis.drive.voltage.sub):
            return
        self._pending = None
        if command & 0xE2 == 0x42:
            # Expedited: where the size is indicated, four bytes less the unused ones.
            size = 4 - (command >> 2 & 3) if command & 1 else axis.voltage_size
            raw = int.from_bytes(value[:size], "little", signed=voltage_is_signed(axis.drive))
            axis.take_polled_voltage(raw, self._link.now())
