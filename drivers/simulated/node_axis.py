"""One axis of a simulated node that has several: its drive knows the objects of a first axis only.

Written without `drivers.canopen`, which the simulated node tests. Of axis 2, the makers' objects 2000h to
27FFh stand 800h higher, as CiA 402 has it for 6000h to 67FFh; 64 PDOs belong to each axis.
"""

import struct
from collections.abc import Sequence

from drivers.simulated.objects import Send

_BEGINNINGS, _ADDRESSED = (1, 2), (2, 3, 4)
"""Command specifiers of SDO (the upper three bits): requests that begin a transfer, answers that name the object."""
_PDOS, _PROFILE = range(0x1400, 0x1C00), range(0x2000, 0xA000)
_MAPPINGS = {*range(0x1600, 0x1800), *range(0x1A00, 0x1C00)}
_ENTRY = struct.Struct("<4xHH")
"""An entry of a mapping in an SDO frame: length and sub-index, index."""


class NodeAxis:
    """What passes between the bus and the drive of one axis; the first axis of the node answers for the node."""

    def __init__(self, node_id: int, axis: int, axes: Sequence[int], send: Send) -> None:
        """`axes` of the node, the first one first; areas of axes that are not there are those of the first one."""
        self._sdo, self._life, self._send = 0x580 + node_id, 0x700 + node_id, send
        self._axis, self._axes = axis, axes
        self.is_first = axis == axes[0]
        self.is_off = False
        """Whether the controller is cut off from the bus."""
        self._takes_part = False
        """Whether the present SDO transfer is for this axis or the node."""
        self._answers = False
        self._asked = bytes(3)
        """Address of the object in it, as on the bus."""

    def leave_bus(self) -> None:
        """Send and hear nothing any more."""
        self.is_off = True

    def own(self, index: int) -> int | None:
        """The index at which the drive has an object of the node; None: it is another axis's."""
        for area, size, first in ((_PDOS, 0x40, 0x200), (_PROFILE, 0x800, 0x4000)):
            if index in area:
                axis = (index - area.start) % first // size + 1
                if axis == self._axis:
                    return index - (axis - 1) * size
                return index if self.is_first and axis not in self._axes else None
        return index

    def request(self, data: bytes) -> bytes | None:
        """An SDO request as the drive sees it; None: it is not for this axis."""
        if data[0] >> 5 in _BEGINNINGS:
            self._asked = data[1:4]
            index = int.from_bytes(data[1:3], "little")
            own = self.own(index)
            self._takes_part = own is not None
            self._answers = self.is_first or index in _PDOS or index in _PROFILE
            if own is not None:
                data = data[:1] + own.to_bytes(2, "little") + data[3:]
                if self._is_entry:
                    length, mapped = _ENTRY.unpack(data)
                    data = data[:4] + struct.pack("<HH", length, self.own(mapped) or 0)
        return data if self._takes_part else None

    @property
    def _is_entry(self) -> bool:
        return int.from_bytes(self._asked[:2], "little") in _MAPPINGS and self._asked[2] > 0

    def send(self, arbitration_id: int, data: bytes) -> None:
        """Send what the drive sends, as it looks on the bus."""
        if self.is_off or (arbitration_id == self._life and not self.is_first):
            return
        if arbitration_id == self._sdo:
            if not self._answers:
                return
            if data[0] >> 5 in _ADDRESSED:
                data = data[:1] + self._asked + data[4:]
            if data[0] >> 5 == 2 and self._is_entry:
                length, mapped = _ENTRY.unpack(data)
                data = data[:4] + struct.pack("<HH", length, self._on_node(mapped))
        self._send(arbitration_id, data)

    def _on_node(self, index: int) -> int:
        moved = index + (self._axis - 1) * 0x800
        return moved if self.own(moved) == index else index
