"""Damage to files: bytes of any file, words of text, values of JSON, content of the chunks of MCAP."""

import json
import re
import zlib
from typing import Any

import numpy as np
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Chunk

from recordings.chunk import RECORD, RECORD_HEAD, unpacked
from recordings.container import DECODE_ERRORS, MAGIC, decode
from tests.fuzz.inputs import mutated

_DEEP: Any = 1
for _ in range(100):
    _DEEP = [_DEEP]
_VALUES: list[Any] = [None, True, "", "x", "é\0", [], {}, [1, 2], [[1, 2], [3]], {"a": 1}, _DEEP]
_NUMBERS: list[Any] = [0, -1, 1, 4, 1e-320, 1e12, 1e300, 10**30, 10**400, float("nan"), float("inf")]
_WORDS = ["1" * 5000, "[" * 10_000, '{"a":' * 10_000, "a." * 5000, "\r", "\n", "nan", "-", '"', ",,,", "1e999", "\0"]
_TEXT = (".json", ".toml", ".csv", ".eds", ".py")


def damaged(data: bytes, suffix: str, rng: np.random.Generator) -> bytes:
    """The content `data` of a file whose name ends with `suffix`, damaged at random places."""
    kind = rng.random()
    if suffix == ".mcap" and kind < 0.5:
        return _other_chunks(data, rng)
    if suffix == ".json" and kind < 0.7:
        return _other_values(data, rng)
    if suffix in _TEXT and kind < 0.8:
        return _other_words(data.decode(), rng).encode()
    return mutated(data, rng)


def _other_values(data: bytes, rng: np.random.Generator) -> bytes:
    """Replace, delete or repeat one to three values of a JSON document."""
    content = json.loads(data)
    for _ in range(int(rng.integers(1, 4))):
        holders = [
            (each, key)
            for each in _holders(content)
            for key in (each if isinstance(each, dict) else range(len(each)))
        ]
        if not holders:
            break
        holder, key = holders[int(rng.integers(len(holders)))]
        choice = rng.random()
        if choice < 0.6:
            values = _VALUES + 2 * _NUMBERS
            holder[key] = values[int(rng.integers(len(values)))]
        elif choice < 0.8:
            del holder[key]
        elif isinstance(holder, list):
            holder.insert(key, holder[key])
        else:
            holder[f"{key}_"] = holder[key]
    return json.dumps(content).encode()


def _holders(content: Any) -> list[Any]:
    """All objects and arrays of a document, without those of `_VALUES`."""
    if not isinstance(content, dict | list) or any(content is value for value in _VALUES):
        return []
    inner = content.values() if isinstance(content, dict) else content
    return [content, *(holder for value in inner for holder in _holders(value))]


def _other_words(text: str, rng: np.random.Generator) -> str:
    """Replace, delete or repeat one to three words or lines of a text, or its line ends."""
    for _ in range(int(rng.integers(1, 4))):
        words = re.findall(r"[\w.+-]+|\s+|.", text) or [""]
        at, choice = int(rng.integers(len(words))), rng.random()
        if choice < 0.1:
            text = text.replace("\n", str(rng.choice(["\r", "\r\n", ""])))
            continue
        if choice < 0.6:
            words[at] = str(rng.choice([*_WORDS, *map(str, _NUMBERS)]))
        elif choice < 0.8:
            del words[at : at + int(rng.integers(1, 20))]
        else:
            words[at:at] = words[at : at + int(rng.integers(1, 20))]
        text = "".join(words)
    return text


def _other_chunks(data: bytes, rng: np.random.Generator) -> bytes:
    """Damage records of an MCAP file inside of their chunks, which then have a checksum that fits."""
    parts, offset = [MAGIC], len(MAGIC)
    while offset + RECORD_HEAD <= len(data) - len(MAGIC):
        opcode, length = RECORD.unpack_from(data, offset)
        record, offset = data[offset : offset + RECORD_HEAD + length], offset + RECORD_HEAD + length
        if rng.random() < 0.3:
            record = _other_record(opcode, record, rng)
        parts.append(record)
    return b"".join([*parts, MAGIC])


def _other_record(opcode: int, record: bytes, rng: np.random.Generator) -> bytes:
    if opcode != Opcode.CHUNK:
        body = mutated(record[RECORD_HEAD:] or b"\0", rng)
        return RECORD.pack(opcode, len(body)) + body
    try:
        chunk: Chunk = decode(Chunk.read, record[RECORD_HEAD:])
        content = mutated(unpacked(chunk), rng)
    except DECODE_ERRORS:
        return record
    chunk.data, chunk.compression = zstandard.compress(content), "zstd"
    chunk.uncompressed_size, chunk.uncompressed_crc = len(content), zlib.crc32(content)
    builder: Any = RecordBuilder()  # without annotations
    chunk.write(builder)
    return bytes(builder.end())
