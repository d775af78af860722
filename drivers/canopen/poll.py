"""Read numbers by SDO in the cycle: voltages that cannot be mapped into a PDO, a velocity that is compared, states
that are watched."""

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import cycle

from drivers.canopen.axis import CanopenAxis
from drivers.canopen.bus import Link
from drivers.canopen.node_axes import on_node
from drivers.canopen.pdo import voltage_is_signed
from drivers.canopen.sdo import format_address
from drivers.eds import Address
from drivers.protocol import Report
from recordings.drives import WatchedObject

_REQUEST_TIMEOUT = 50
"""Number of cycles after which an unanswered request is dropped."""
_UPLOAD = struct.Struct("<BHB4x")
_RESPONSE = struct.Struct("<BHB4s")


@dataclass(frozen=True)
class PolledVelocity:
    """Velocity actual (606Ch) of one drive in a run."""

    unit: float
    """Speed of the joint that is one unit of it, as the drive states it, with the joint's sign [rad/s or m/s]."""
    stamps: list[int] = field(default_factory=list)
    """When each value arrived [ns]."""
    values: list[int] = field(default_factory=list)

    def take(self, raw: int, stamp: int) -> None:
        """Note a value that arrived at `stamp` [ns]."""
        self.stamps.append(stamp)
        self.values.append(raw)


class WatchedState:
    """One object of `watched` of a drive; its changes are reported."""

    def __init__(self, axis: CanopenAxis, watched: WatchedObject, report: Report) -> None:
        self._axis, self._watched, self._report = axis, watched, report
        self._before = ""

    def take(self, raw: int, stamp: int) -> None:
        """Report a value that differs from the last one."""
        watched = self._watched
        value = str(raw) if watched.mask is None else f"0x{raw & watched.mask:X}"
        if value != self._before:
            was = f", was {self._before}" if self._before else ""
            what = f"{watched.name} {format_address(watched.index, watched.sub)}".lstrip()
            self._report("info", self._axis.name, f"{what} = {value}{was}")
            self._before = value


_Polled = tuple[CanopenAxis, Address, Callable[[int, int], None] | None]
"""A drive and its object, at the index that it has on a first axis; what takes its signed number and when it arrived
[ns], None: a voltage."""


class VoltagePoll:
    """Polls the drives in turn, one pending request at a time; the cycle never waits for a response."""

    def __init__(self, axes: Sequence[CanopenAxis], link: Link) -> None:
        self.axes = axes
        self._link = link
        self._polled: list[_Polled] = [
            (axis, (axis.drive.voltage.index, axis.drive.voltage.sub), None) for axis in axes
        ]
        self._turns = cycle(self._polled)
        self._pending: _Polled | None = None
        self._request_cycle = 0

    def add(self, axis: CanopenAxis, address: Address, take: Callable[[int, int], None]) -> None:
        """Poll an integer of a drive, too."""
        self._polled.append((axis, address, take))
        self._turns = cycle(self._polled)

    def request(self, number: int) -> None:
        """Send a request to the next drive in cycle `number`, unless one is pending."""
        if not self._polled or (self._pending is not None and number - self._request_cycle < _REQUEST_TIMEOUT):
            return
        self._pending = next(self._turns)
        self._request_cycle = number
        axis, (index, sub), _ = self._pending
        self._link.send(0x600 + axis.drive.node_id, _UPLOAD.pack(0x40, on_node(index, axis.drive.axis), sub))

    def take_response(self, axes: Sequence[CanopenAxis], data: bytes) -> None:
        """Process an SDO response of the node of `axes` if it answers the pending request; an abort ends that."""
        if self._pending is None or self._pending[0] not in axes or len(data) != _RESPONSE.size:
            return
        axis, address, take = self._pending
        command, index, sub, value = _RESPONSE.unpack(data)
        if (index, sub) != (on_node(address[0], axis.drive.axis), address[1]):
            return
        self._pending = None
        if command & 0xE2 != 0x42:
            return
        usual, signed = (4, True) if take else (axis.voltage_size, voltage_is_signed(axis.drive))
        # Expedited: where the size is indicated, four bytes less the unused ones.
        size = 4 - (command >> 2 & 3) if command & 1 else usual
        raw, stamp = int.from_bytes(value[:size], "little", signed=signed), self._link.now()
        (take or axis.take_polled_voltage)(raw, stamp)
