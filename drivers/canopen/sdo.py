"""SDO access to one drive without a receiver thread: typed, with actionable error messages."""

import logging
import struct
from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

from canopen import ObjectDictionary
from canopen.sdo import SdoAbortedError, SdoClient, SdoCommunicationError
from canopen.sdo.constants import REQUEST_DOWNLOAD, REQUEST_UPLOAD, RESPONSE_ABORTED

from drivers import patience
from drivers.canopen.bus import Link
from drivers.canopen.node_axes import on_node
from drivers.protocol import LOCKSTEP_TIMEOUT
from recordings.errors import RunFailed

_SECOND_RESPONSE_TIMEOUT = 0.01
"""Time that a second drive under the same node id may answer after the first [s]."""
READ_DEVICE_TYPE = bytes.fromhex("4000100000000000")
"""SDO request that any node answers (object 1000)."""
_ABORT_CODE = struct.Struct("<4xL")
_EXPEDITED, _UNSIZED = 0xE3, 0x42
"""Bits of the command specifier of an upload, and their values where four bytes come without their number."""
_NO_OBJECT = (0x0602_0000, 0x0609_0011, 0x0800_0000, 0x0601_0000, 0x0604_0043)
"""Abort codes: no such object, no such sub-index; and general ones, which some drives have for both."""
_ABORT_WITHOUT_ADDRESS = b"\x80\0\0\0"
"""Some drives omit the object's address in an abort."""


class _PollingClient(SdoClient):  # type: ignore[misc]
    """canopen's client, reading its responses from the link instead of receiving them from another thread."""

    def __init__(self, node_id: int, link: Link, on_other_frame: Callable[[int, bytes], None]) -> None:
        super().__init__(0x600 + node_id, 0x580 + node_id, ObjectDictionary())
        self.network = SimpleNamespace(send_message=lambda can_id, data: link.send(can_id, bytes(data)))
        self._link = link
        self._on_other_frame = on_other_frame
        self._request = b""
        self.is_sized = True
        """Whether the last response says how many of its bytes count, as CiA 301 leaves to the drive."""

    def send_request(self, request: bytes) -> None:
        # Frames that have already arrived do not answer this request. canopen would take a repeated response for the
        # answer to the next request, even if that request was lost.
        for frame in self._link.frames(0.0):
            self._on_other_frame(*frame)
        self._request = bytes(request)
        super().send_request(request)

    def _is_response(self, data: bytes) -> bool:
        """Whether a response answers the last request. Responses to segments carry no address."""
        begins = self._request[0] & 0xE0 in (REQUEST_DOWNLOAD, REQUEST_UPLOAD)
        return not begins or data[1:4] == self._request[1:4] or data[:4] == _ABORT_WITHOUT_ADDRESS

    def read_response(self) -> bytes:
        in_lockstep = self._link.clock is not None
        timeout = max(self.RESPONSE_TIMEOUT, patience.factor() * LOCKSTEP_TIMEOUT if in_lockstep else 0.0)
        for arbitration_id, data in self._link.frames(timeout):
            if arbitration_id != self.tx_cobid or len(data) != 8 or not self._is_response(data):
                self._on_other_frame(arbitration_id, data)
                continue
            if data[0] == RESPONSE_ABORTED:
                raise SdoAbortedError(_ABORT_CODE.unpack(data)[0])
            self.is_sized = data[0] & _EXPEDITED != _UNSIZED
            return data
        raise SdoCommunicationError("no SDO response received")

    def count_further_responses(self, duration: float) -> int:
        """Number of unrequested responses within `duration` [s]."""
        count = 0
        for frame in self._link.frames(duration):
            if frame[0] == self.tx_cobid:
                count += 1
            else:
                self._on_other_frame(*frame)
        return count


@dataclass(frozen=True)
class SdoWrite:
    """One SDO download; `layout` is the struct format of its type."""

    index: int
    sub: int
    layout: str
    value: int
    check: bool = True
    """Whether it is read back."""
    mask: int = -1
    """Bits that are compared when it is read back."""


class ObjectRefused(RunFailed):
    """The drive has no such object, refuses the request, or answers with too few bytes."""


class ObjectMissing(ObjectRefused):
    """The drive has no such object or sub-index."""


class Sdo:
    """Access to the object dictionary of one drive: objects are named as those of the first axis of its node."""

    def __init__(
        self, node_id: int, name: str, link: Link, on_other_frame: Callable[[int, bytes], None], axis: int = 1
    ) -> None:
        """`name` of the drive in errors; `on_other_frame` receives the other frames that arrive meanwhile."""
        # canopen logs every abort and timeout that it also raises.
        logging.getLogger("canopen").setLevel(logging.CRITICAL)
        self._client: Any = _PollingClient(node_id, link, on_other_frame)
        self._name, self._axis = name, axis
        self._node = node_id, name, link, on_other_frame

    def of_axis(self, axis: int) -> "Sdo":
        """Access to another axis of the same node."""
        return Sdo(*self._node, axis)

    def count_answers(self) -> int:
        """Number of drives that answer under this node id when the device type (object 1000) is read."""
        try:
            self._client.upload(0x1000, 0)
        except SdoAbortedError:
            pass
        except SdoCommunicationError:
            return 0
        return 1 + self._client.count_further_responses(_SECOND_RESPONSE_TIMEOUT)

    def read(self, index: int, sub: int, layout: str) -> int:
        """Read an integer object; `layout` is its struct format, e.g. "<I".

        Raises:
            RunFailed: no answer, or the drive refuses the request.
        """
        data = self.read_bytes(index, sub)
        size = struct.calcsize(layout)
        if len(data) < size:
            raise ObjectRefused(
                f"{self._name}: object {format_address(index, sub)} has {len(data)} bytes, {size} expected"
            )
        return struct.unpack(layout, data[:size])[0]

    def read_bytes(self, index: int, sub: int) -> bytes:
        """Read an object of any size.

        Raises:
            RunFailed: no answer, or the drive refuses the request.
        """
        return bytes(self._transfer("read", index, sub, self._client.upload))

    @property
    def is_sized(self) -> bool:
        """Whether the last object that was read came with its size."""
        return bool(self._client.is_sized)

    def read_optional(self, index: int, sub: int, layout: str) -> int | None:
        """As `read`, but None where the drive has no such object or refuses to read it."""
        try:
            return self.read(index, sub, layout)
        except ObjectRefused:
            return None

    def has(self, index: int, sub: int) -> bool:
        """Whether the drive has an object, even if it refuses to read it."""
        try:
            self.read_bytes(index, sub)
        except ObjectMissing:
            return False
        except ObjectRefused:
            pass
        return True

    def read_text(self, index: int, sub: int = 0) -> str:
        """Read a visible string; "" where the drive has none or refuses to read it."""
        try:
            return self.read_bytes(index, sub).decode("ascii", "replace").rstrip("\0")
        except ObjectRefused:
            return ""

    def write(self, write: SdoWrite) -> None:
        """Write an integer object and read it back if it is to be compared and can be read.

        Raises:
            RunFailed: no answer, the drive refuses, or it reads back another value.
        """
        index, sub, data = write.index, write.sub, struct.pack(write.layout, write.value)
        self._transfer("write", index, sub, self._client.download, data)
        actual = self.read_optional(index, sub, write.layout) if write.check else None
        if actual is not None and (actual ^ write.value) & write.mask:
            raise RunFailed(
                f"{self._name}: object {format_address(index, sub)} was written {write.value:#x} and reads back "
                f"{actual:#x}; check what the drive supports"
            )

    def _transfer(self, verb: str, index: int, sub: int, transfer: Callable[..., Any], *data: bytes) -> Any:
        index = on_node(index, self._axis)
        try:
            return transfer(index, sub, *data)
        except SdoAbortedError as error:
            text = f"{self._name} refuses to {verb} object {format_address(index, sub)}: {error}"
            raise (ObjectMissing if error.code in _NO_OBJECT else ObjectRefused)(text) from None
        except SdoCommunicationError:
            raise RunFailed(
                f"{self._name} does not answer (SDO {verb} of object {format_address(index, sub)}); "
                "check its power, its node id and the bus"
            ) from None


def format_address(index: int, sub: int) -> str:
    """Address of an object as printed in manuals."""
    return f"{index:04X}:{sub:02X}"
