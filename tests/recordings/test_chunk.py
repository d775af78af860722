"""Messages are where their index says only if a walk from one record to the next says so, too."""

import struct
from collections import defaultdict
from itertools import accumulate

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.opcode import Opcode

from recordings.chunk import RECORD_HEAD, Offsets, located

MESSAGE, SCHEMA = int(Opcode.MESSAGE), int(Opcode.SCHEMA)
RECORDS = st.lists(st.tuples(st.just(MESSAGE), st.integers(0, 2), st.integers(22, 24)), min_size=1, max_size=30)


def chunk(records: list[tuple[int, int, int]]) -> bytes:
    """Records of these opcodes, channels and lengths."""
    return b"".join(
        struct.pack("<BQH", opcode, length, channel) + bytes(length - 2) for opcode, channel, length in records
    )


def offsets_of(records: list[tuple[int, int, int]]) -> list[int]:
    return [0, *accumulate(RECORD_HEAD + length for _, _, length in records)][:-1]


def message_indexes(records: list[tuple[int, int, int]]) -> list[bytes]:
    """Bodies of the message indexes, each message with its log time, here 7 ns."""
    entries = defaultdict(list)
    for (opcode, channel, _), offset in zip(records, offsets_of(records), strict=True):
        if opcode == MESSAGE:
            entries[channel] += [7, offset]
    return [struct.pack(f"<HI{len(e)}Q", channel, 8 * len(e), *e) for channel, e in entries.items()]


def as_lists(offsets: Offsets) -> list[tuple[tuple[int, int], list[int]]]:
    return [(key, values.tolist()) for key, values in offsets.items()]


@given(RECORDS)
def test_the_index_locates_what_a_walk_locates(records: list[tuple[int, int, int]]) -> None:
    data, indexes = chunk(records), message_indexes(records)
    walked, others = located(data)
    indexed, none = located(data, indexes)
    assert as_lists(indexed) == as_lists(walked)
    assert others == none == []
    assert sum(map(len, walked.values())) == len(records)


@pytest.mark.parametrize(
    "damage", ["lacking", "shifted", "beyond", "channel", "empty", "cut", "other records", "twice"]
)
def test_an_index_that_does_not_fit_is_not_used(damage: str) -> None:
    records = [(MESSAGE, channel, 30) for channel in (0, 1, 1, 0, 2)]
    if damage == "other records":
        records.insert(2, (SCHEMA, 0, 40))
    data, indexes = chunk(records), message_indexes(records)
    body = indexes[0]
    indexes[0] = {
        "lacking": body[:6] + body[22:],
        "shifted": body[:-8] + struct.pack("<Q", 3),
        "beyond": body[:-8] + struct.pack("<Q", 2**64 - 1),
        "channel": b"\1" + body[1:],
        "empty": body[:6],
        "cut": body[:-1],
        "other records": body,
        "twice": body + body[6:],
    }[damage]
    walked, others = located(data)
    assert (as_lists(located(data, indexes)[0]), located(data, indexes)[1]) == (as_lists(walked), others)
    assert len(others) == (damage == "other records")
    assert sorted(np.concatenate(list(walked.values())).tolist()) == [
        offset for (opcode, _, _), offset in zip(records, offsets_of(records), strict=True) if opcode == MESSAGE
    ]
