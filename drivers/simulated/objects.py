"""The objects of one simulated drive: their values, and what an SDO access to them is answered."""

import logging
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from canopen.sdo import SdoAbortedError, SdoServer

from drivers.eds import Address, Dictionary
from drivers.simulated.habits import Habits, parse_address

WRITE_ONLY, READ_ONLY = 0x06010001, 0x06010002
NO_OBJECT, NO_SUB_INDEX = 0x06020000, 0x06090011
WRONG_LENGTH = 0x06070010
INVALID_VALUE, TOO_HIGH, TOO_LOW = 0x06090030, 0x06090031, 0x06090032
REFUSED = 0x08000020
_FACTORS = range(0x608F, 0x6098)
_DEVICE_TYPE, _CIA_402 = (0x1000, 0), 0x0002_0192

Send = Callable[[int, bytes], None]


class Objects:
    """Values of the objects. `measured` are computed when they are read; `on_write` is asked before a change.

    `on_write(address, value)` may raise SdoAbortedError.
    """

    object_dictionary: Any = None

    def __init__(
        self,
        dictionary: Dictionary,
        habits: Habits,
        on_write: Callable[[Address, int], None],
        node_id: int,
        send: Send,
    ) -> None:
        self.dictionary = dictionary
        self._on_write = on_write
        self.measured: dict[Address, Callable[[], int]] = {}
        self._values: dict[Address, bytes] = {}
        self._decoded: dict[Address, int] = {}
        self._allowed = {parse_address(text): values for text, values in habits.allowed.items()}
        self._unreadable = {parse_address(text) for text in habits.refuse_read}
        self._unwritable = {parse_address(text) for text in habits.refuse_write}
        self._at_power_on = {parse_address(text): value for text, value in habits.values.items()}
        # canopen logs every request that it also refuses on the bus.
        logging.getLogger("canopen").setLevel(logging.CRITICAL)
        self.server: Any = SdoServer(0x600 + node_id, 0x580 + node_id, self)
        self.server.network = SimpleNamespace(send_message=lambda can_id, data: send(can_id, bytes(data)))
        # canopen's server can refuse a segment without a transfer only if these are numbers.
        self.server._index = self.server._subindex = 0
        self.server._buffer = bytearray()

    def restore(self, *, communication_only: bool = False) -> None:
        """Set the values at power-on again; `communication_only`: of the objects 1000h to 1FFFh."""
        kept = {a: data for a, data in self._values.items() if communication_only and not 0x1000 <= a[0] < 0x2000}
        self._values = kept
        self._decoded.clear()

    # By the drive itself

    def __contains__(self, address: Address) -> bool:
        return address in self.dictionary

    def value(self, index: int, sub: int = 0, absent: int = 0) -> int:
        """Value of an integer object; `absent` where the dictionary has none. Cached, because all PDOs need it."""
        address = (index, sub)
        cached = self._decoded.get(address)
        if cached is None:
            if address not in self.dictionary:
                return absent
            cached = self._decoded[address] = self.dictionary[address].decode(self._stored(address))
        return cached

    def store(self, address: Address, data: bytes) -> None:
        """Store a value without asking."""
        self._values[address] = data
        self._decoded.pop(address, None)

    def set(self, index: int, sub: int, value: int) -> None:
        """Store an integer, limited to the object's type; nothing where the dictionary has no such object."""
        if (index, sub) in self.dictionary:
            self.store((index, sub), self.dictionary[index, sub].encode(value))

    def read(self, address: Address) -> bytes:
        """Present bytes of an object, measured or stored."""
        measure = self.measured.get(address)
        return self._stored(address) if measure is None else self.dictionary[address].encode(measure())

    def _stored(self, address: Address) -> bytes:
        data = self._values.get(address)
        if data is None:
            data = self._values[address] = self._initial(address)
        return data

    def _initial(self, address: Address) -> bytes:
        entry = self.dictionary[address]
        if address in self._at_power_on:
            return entry.encode(self._at_power_on[address])
        if entry.value is not None:
            return entry.value
        if not entry.is_integer:
            return b"" if entry.size is None else bytes(entry.size)
        if address == _DEVICE_TYPE:
            return entry.encode(_CIA_402)
        # A drive always has some factor; one that the file does not give changes nothing.
        return entry.encode(1 if address[0] in _FACTORS and address[1] else 0)

    # By SDO: the interface of canopen's server

    def get_data(self, index: int, subindex: int, check_readable: bool = False) -> bytes:
        """Bytes of an object for an SDO upload."""
        entry = self._described(index, subindex)
        if not entry.is_readable:
            raise SdoAbortedError(WRITE_ONLY)
        if (index, subindex) in self._unreadable:
            raise SdoAbortedError(REFUSED)
        return self.read((index, subindex))

    def set_data(self, index: int, subindex: int, data: bytes, check_writable: bool = False) -> None:
        """Store the bytes of an SDO download, or refuse them."""
        address, entry = (index, subindex), self._described(index, subindex)
        if not entry.is_writable:
            raise SdoAbortedError(READ_ONLY)
        if entry.size is not None and len(data) != entry.size:
            raise SdoAbortedError(WRONG_LENGTH)
        if address in self._unwritable:
            raise SdoAbortedError(REFUSED)
        if entry.is_integer:
            value = entry.decode(bytes(data))
            self._check_value(address, value)
            self._on_write(address, value)
        self.store(address, bytes(data))

    def _described(self, index: int, sub: int) -> Any:
        entry = self.dictionary.get((index, sub))
        if entry is None:
            raise SdoAbortedError(NO_SUB_INDEX if index in self.dictionary.indices else NO_OBJECT)
        return entry

    def _check_value(self, address: Address, value: int) -> None:
        entry = self.dictionary[address]
        if entry.low is not None and value < entry.low:
            raise SdoAbortedError(TOO_LOW)
        if entry.high is not None and value > entry.high:
            raise SdoAbortedError(TOO_HIGH)
        if value not in self._allowed.get(address, (value,)):
            raise SdoAbortedError(INVALID_VALUE)
