"""Messages in a chunk of an MCAP file, which are located and viewed rather than decoded.

They are located by the index that follows the chunk, or one after the other. Those with the same length are then
viewed as one numpy array.
"""

import struct
import zlib
from collections import defaultdict
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import lz4.frame
import numpy as np
import zstandard
from mcap.opcode import Opcode
from mcap.records import Chunk
from numpy.typing import NDArray

from recordings.cdr import Layout
from recordings.limits import Allowance

RECORD = struct.Struct("<BQ")
"""Opcode and length that precede every record."""
RECORD_HEAD = RECORD.size
"""Their size [bytes]."""
_MESSAGE = struct.Struct("<BQH")
MESSAGE_HEAD = np.dtype(
    [("opcode", "u1"), ("length", "<u8"), ("channel", "<u2"), ("sequence", "<u4"), ("log", "<u8"), ("publish", "<u8")]
)
"""Header of a Message record; `log` and `publish` are times [ns]."""

_LOCATED = np.dtype(MESSAGE_HEAD.descr[:3])
"""What of the header tells where the next record is, and which one it is."""

_INDEX_HEAD = 6
"""Size of the channel and the length that precede the entries of a message index [bytes]."""
Offsets = dict[tuple[int, int], NDArray[np.integer]]
"""Offsets of messages in an unpacked chunk, ascending, by channel and length."""


def unpacked(chunk: Chunk, allowance: Allowance | None = None) -> bytes:
    """Uncompressed records of a chunk.

    allowance: of the file, if its other chunks count.

    Raises one of `container.DECODE_ERRORS` where the chunk is damaged or has another size than it declares.
    """
    size = chunk.uncompressed_size
    (allowance or Allowance()).take(size, len(chunk.data))
    # One byte more than declared, so that a chunk that holds more is not taken for a whole one.
    data = _decompressed(chunk.compression, chunk.data, size + 1)
    if len(data) != size or chunk.uncompressed_crc not in (0, zlib.crc32(data)):  # 0: written without a checksum
        raise ValueError("a chunk does not hold what it declares")
    return data


def _decompressed(compression: str, data: bytes, most: int) -> bytes:
    if compression == "":
        return data
    if compression == "zstd":
        return zstandard.ZstdDecompressor().stream_reader(data).read(most)
    if compression == "lz4":
        try:
            return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data, most))
        except RuntimeError as error:
            raise ValueError(str(error)) from None
    raise ValueError(f"the compression {compression[:20]!r} of a chunk is not known")


def beginning(chunk: Chunk) -> bytes:
    """Whole records in a chunk whose data were not written to the end.

    Raises one of `container.DECODE_ERRORS` where it is damaged.
    """
    Allowance().take(chunk.uncompressed_size, len(chunk.data))
    data, end, after = _decompressed(chunk.compression, chunk.data, chunk.uncompressed_size), 0, 0
    while after <= len(data):
        end, head = after, data[after : after + RECORD_HEAD]
        after += RECORD_HEAD + (RECORD.unpack(head)[1] if len(head) == RECORD_HEAD else 0)
    return data[:end]


def located(data: bytes, index: Sequence[bytes] = ()) -> tuple[Offsets, list[tuple[int, bytes]]]:
    """Messages in an unpacked chunk; and opcode and body of all other records.

    index: bodies of the message indexes of the chunk, which save time where they are complete.
    """
    indexed = _indexed(data, index)
    if indexed is not None:
        return indexed, []
    messages: dict[tuple[int, int], list[int]] = defaultdict(list)
    other_records = []
    message = int(Opcode.MESSAGE)  # an enumeration takes longer to compare than a record to unpack
    offset, end = 0, len(data)
    while offset < end:
        opcode, length, channel = _MESSAGE.unpack_from(data, offset)
        start = offset + RECORD_HEAD
        if opcode == message:
            messages[channel, length].append(offset)
        else:
            other_records.append((opcode, data[start : start + length]))
        offset = start + length
    return {key: np.array(offsets) for key, offsets in messages.items()}, other_records


def _indexed(data: bytes, index: Sequence[bytes]) -> Offsets | None:
    """Messages by the `index` of their chunk; None unless these follow each other and fill the chunk."""
    if not index or any((len(body) - _INDEX_HEAD) % 16 for body in index):
        return None
    groups: list[tuple[int, int, NDArray[np.integer]]] = []
    for body in index:
        offsets = np.sort(np.frombuffer(body, "<u8", offset=_INDEX_HEAD)[1::2])
        if not len(offsets) or offsets[-1] > len(data) - _LOCATED.itemsize:
            return None
        heads = _windows(data, _LOCATED)[offsets]
        channel = int.from_bytes(body[:2], "little")
        if (heads["opcode"] != Opcode.MESSAGE).any() or (heads["channel"] != channel).any():
            return None
        lengths = heads["length"]
        groups += [(channel, length, offsets[lengths == length]) for length in _distinct(lengths)]
    groups.sort(key=lambda messages: int(messages[2][0]))
    starts = np.sort(np.concatenate([offsets for _, _, offsets in groups]))
    ends = np.sort(np.concatenate([offsets + np.uint64(RECORD_HEAD + length) for _, length, offsets in groups]))
    if starts[0] != 0 or ends[-1] != len(data) or (starts[1:] != ends[:-1]).any():
        return None
    return {(channel, length): offsets for channel, length, offsets in groups}


def _distinct(lengths: NDArray[np.integer]) -> list[int]:
    """The different ones of some `lengths`, which are mostly all the same."""
    return (lengths[:1] if (lengths == lengths[0]).all() else np.unique(lengths)).tolist()


def rows(data: bytes, length: int, offsets: NDArray[np.integer]) -> NDArray[np.uint8]:
    """Message records of one length at `offsets`, as bytes (n, record size)."""
    size = RECORD.size + length
    return _windows(data, np.dtype((np.void, size)))[offsets].view(np.uint8).reshape(-1, size)


def _windows(data: bytes, dtype: np.dtype[Any]) -> NDArray[Any]:
    """View all bytes from which a value of the `dtype` would fit as such values, which overlap."""
    return np.ndarray(max(len(data) - dtype.itemsize + 1, 0), dtype, data, strides=1)


@lru_cache
def message_record(layout: Layout) -> np.dtype[Any]:
    """Dtype of a Message record: `MESSAGE_HEAD`, then `message` with the fields of `layout`."""
    return np.dtype([*MESSAGE_HEAD.descr, ("message", layout.dtype)])
