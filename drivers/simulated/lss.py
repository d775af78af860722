"""LSS (CiA 305) of one simulated node; what is stored takes effect when the node is reset.

Written without `drivers.canopen`, which the simulated node tests.
"""

import struct

from drivers.simulated.objects import Objects, Send

REQUEST, _ANSWER = 0x7E5, 0x7E4
_SWITCH_ALL, _SWITCH_ONE, _SWITCHED = 0x04, range(0x40, 0x44), 0x44
_NODE_ID, _BIT_RATE, _STORE = 0x11, 0x13, 0x17
_INQUIRE = range(0x5A, 0x5E)
_BIT_RATES = {*range(9)} - {5}
"""Indices in table 0."""


class LssSlave:
    """State of one node."""

    def __init__(self, objects: Objects, send: Send) -> None:
        self._objects, self._send = objects, send
        self._configures = False
        self._matching = 0
        """How many numbers of the last call for one node are those of this one."""
        self._node_id: int | None = None
        self.stored: int | None = None
        """Node id from the next reset on; None: as it is."""

    def receive(self, data: bytes) -> None:
        """Process one request."""
        command, number = data[0], int.from_bytes(data[1:5], "little")
        if command == _SWITCH_ALL:
            self._configures = data[1] == 1
        elif command in _SWITCH_ONE:
            part = command - _SWITCH_ONE.start
            fits = number == self._number(part) and self._matching >= part
            self._matching = part + 1 if fits else 0
            if self._matching == len(_SWITCH_ONE):
                self._configures = True
                self._answer(_SWITCHED)
        elif self._configures and command in _INQUIRE:
            self._answer(command, *struct.pack("<I", self._number(command - _INQUIRE.start)))
        elif self._configures and command in (_NODE_ID, _BIT_RATE, _STORE):
            self._answer(command, self._configure(command, data))

    def _number(self, part: int) -> int:
        """Vendor, product, revision or serial number."""
        return self._objects.value(0x1018, part + 1)

    def _configure(self, command: int, data: bytes) -> int:
        """Error code of a service: 0, or 1 for a value that does not exist."""
        if command == _NODE_ID:
            if not 1 <= data[1] <= 127:
                return 1
            self._node_id = data[1]
        elif command == _BIT_RATE:
            return int(data[1] != 0 or data[2] not in _BIT_RATES)
        else:
            self.stored = self._node_id
        return 0

    def _answer(self, command: int, *values: int) -> None:
        self._send(_ANSWER, bytes([command, *values]).ljust(8, b"\0"))
