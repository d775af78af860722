"""The PDOs of a simulated drive: mapping, transmission types, and what a set-up of them is answered (CiA 301)."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from canopen.sdo import SdoAbortedError

from drivers.eds import Address
from drivers.simulated.objects import INVALID_VALUE, Objects, Send

_RECEIVE, _RECEIVE_MAP, _TRANSMIT, _TRANSMIT_MAP = 0x1400, 0x1600, 0x1800, 0x1A00
_COUNT = 512
_INVALID = 0x8000_0000
_COB_ID = 0x7FF
_NOT_MAPPABLE, _TOO_LONG, _WRONG_STATE = 0x06040041, 0x06040042, 0x08000022
_SYNCHRONOUS = 240
"""Highest synchronous transmission type; 0: after a change, n: every n-th SYNC."""
_EVENT = (254, 255)
_DUMMIES = range(1, 8)
"""Data types that an RPDO may map to skip bits."""

Mapping = list[tuple[Address, int]]
"""Objects of a PDO with their lengths [bytes]."""


@dataclass
class _Transmission:
    """State of one TPDO."""

    syncs: int = 0
    last: bytes | None = None
    sent: float = field(default=float("-inf"))


class ProcessData:
    """The PDOs of one node; `written(addresses)` follows what an RPDO has stored."""

    def __init__(self, objects: Objects, send: Send, written: Callable[[list[Address]], None]) -> None:
        self._objects, self._send, self._written = objects, send, written
        self._rpdos = _numbers(objects, _RECEIVE)
        self._tpdos = _numbers(objects, _TRANSMIT)
        self._excess = 0
        """Bytes by which each TPDO is too long; negative: too short."""
        self._mappings: dict[int, Mapping] = {}
        self.restart()

    def restart(self) -> None:
        """Begin anew: the node has become operational, or its PDOs were set up anew."""
        self._mappings.clear()
        self._pending: dict[int, bytes] = {}
        self._state = {number: _Transmission() for number in self._tpdos}
        self.last_received: dict[int, float] = {}
        """When each RPDO with an event timer last arrived [s]."""

    def resize(self, excess: int) -> None:
        """Let the TPDOs be too long by these bytes from now on; negative: too short."""
        self._excess = excess

    # Frames

    def receive(self, arbitration_id: int, data: bytes, now: float) -> None:
        """Take a frame if it is an RPDO; a synchronous one takes effect at the next SYNC."""
        for number in self._rpdos:
            cob_id = self._objects.value(_RECEIVE + number, 1)
            if cob_id & (_INVALID | _COB_ID) != arbitration_id:
                continue
            self.last_received[number] = now
            if self._objects.value(_RECEIVE + number, 2, absent=255) <= _SYNCHRONOUS:
                self._pending[number] = data
            else:
                self._store(number, data)

    def take_pending(self) -> None:
        """Let the RPDOs that came before this SYNC take effect."""
        for number, data in self._pending.items():
            self._store(number, data)
        self._pending.clear()

    def _store(self, number: int, data: bytes) -> None:
        offset, addresses = 0, []
        for address, size in self._mapping(_RECEIVE_MAP + number):
            value = data[offset : offset + size]
            offset += size
            if len(value) == size and address in self._objects:
                self._objects.store(address, value)
                addresses.append(address)
        self._written(addresses)

    def answer_sync(self, now: float) -> None:
        """Send the synchronous TPDOs that are due."""
        for number, cob_id, kind in self._valid_tpdos():
            state = self._state[number]
            if kind > _SYNCHRONOUS:
                continue
            state.syncs += 1
            if kind == 0:
                self._send_change(number, cob_id, now)
            elif state.syncs >= kind:
                state.syncs = 0
                self._transmit(number, cob_id, self._pack(number), now)

    def pass_time(self, now: float) -> None:
        """Send the TPDOs whose event has happened: a change, or the event timer."""
        for number, cob_id, kind in self._valid_tpdos():
            if kind not in _EVENT:
                continue
            since = now - self._state[number].sent
            inhibit, timer = (self._objects.value(_TRANSMIT + number, sub) for sub in (3, 5))
            if timer and since >= timer * 1e-3:
                self._transmit(number, cob_id, self._pack(number), now)
            elif since >= inhibit * 1e-4:
                self._send_change(number, cob_id, now)

    def _valid_tpdos(self) -> Iterator[tuple[int, int, int]]:
        for number in self._tpdos:
            cob_id = self._objects.value(_TRANSMIT + number, 1)
            if not cob_id & _INVALID and self._mapping(_TRANSMIT_MAP + number):
                yield number, cob_id & _COB_ID, self._objects.value(_TRANSMIT + number, 2, absent=255)

    def _send_change(self, number: int, cob_id: int, now: float) -> None:
        data = self._pack(number)
        if data != self._state[number].last:
            self._transmit(number, cob_id, data, now)

    def _transmit(self, number: int, cob_id: int, data: bytes, now: float) -> None:
        state = self._state[number]
        state.last, state.sent = data, now
        self._send(cob_id, (data + bytes(8))[: len(data) + self._excess])

    def _pack(self, number: int) -> bytes:
        return b"".join(self._objects.read(address) for address, _ in self._mapping(_TRANSMIT_MAP + number))[:8]

    def lost_rpdo(self, now: float) -> bool:
        """Whether an RPDO with an event timer (sub-index 5) has not come in time; said once."""
        for number, arrival in self.last_received.items():
            timer = self._objects.value(_RECEIVE + number, 5)
            if timer and now - arrival > timer * 1e-3:
                del self.last_received[number]
                return True
        return False

    # The set-up

    def _mapping(self, index: int) -> Mapping:
        mapping = self._mappings.get(index)
        if mapping is None:
            entries = (self._objects.value(index, sub + 1) for sub in range(self._objects.value(index, 0)))
            mapping = self._mappings[index] = [
                (_address(entry), (entry & 0xFF) // 8)
                for entry in entries
                if _address(entry) in self._objects or entry >> 16 in _DUMMIES
            ]
        return mapping

    def check_write(self, address: Address, value: int, *, operational: bool) -> None:
        """Check a write by SDO to an object of the PDOs.

        Raises:
            SdoAbortedError: with the code of CiA 301.
        """
        index, sub = address
        self._mappings.clear()
        if index - index % _COUNT in (_RECEIVE, _TRANSMIT):
            present = self._objects.value(index, 1) if sub == 1 else value
            if not (present | value) & _INVALID and (present ^ value) & _COB_ID:
                raise SdoAbortedError(INVALID_VALUE)
        elif index - index % _COUNT in (_RECEIVE_MAP, _TRANSMIT_MAP):
            if operational:
                raise SdoAbortedError(_WRONG_STATE)
            self._check_mapping(index, sub, value)

    def _check_mapping(self, index: int, sub: int, value: int) -> None:
        if not self._objects.value(index - 0x200, 1) & _INVALID:
            raise SdoAbortedError(_WRONG_STATE)
        if sub:
            if self._objects.value(index, 0):
                raise SdoAbortedError(_WRONG_STATE)
            if value:
                self._check_mappable(value, dummies=index < _TRANSMIT_MAP)
        elif sum(self._objects.value(index, entry) & 0xFF for entry in range(1, value + 1)) > 64:
            raise SdoAbortedError(_TOO_LONG)

    def _check_mappable(self, value: int, *, dummies: bool) -> None:
        if dummies and value >> 16 in _DUMMIES:
            return
        entry = self._objects.dictionary.get(_address(value))
        if entry is None or not entry.mappable or 8 * (entry.size or 0) != value & 0xFF:
            raise SdoAbortedError(_NOT_MAPPABLE)


def _address(entry: int) -> Address:
    """Index and sub-index in an entry of a mapping."""
    return entry >> 16, entry >> 8 & 0xFF


def _numbers(objects: Objects, first: int) -> list[int]:
    return [
        number
        for number in range(_COUNT)
        if (first + number, 1) in objects and (first + 0x200 + number, 0) in objects
    ]
