"""An hour at 1 kHz with its CAN frames opens within the limits of files of strangers."""

import struct
import subprocess
import sys
import zlib
from collections.abc import Iterator
from itertools import accumulate
from pathlib import Path

import numpy as np
import pytest
import zstandard
from mcap.opcode import Opcode
from mcap.records import Chunk

from recordings.chunk import MESSAGE_HEAD, RECORD, located, rows, unpacked
from recordings.container import decode, open_records
from recordings.recording import Run
from recordings.rig import Rig
from recordings.writer import RecordingWriter

pytestmark = pytest.mark.slow

RATE, SECONDS = 1000, 3600
START_NS = 1_700_000_000_000_000_000
STAMP = slice(MESSAGE_HEAD.itemsize + 4, MESSAGE_HEAD.itemsize + 8)
"""Seconds of the header's stamp, behind the encapsulation."""
MEMORY = 3_000_000_000
"""That the reader may take, libraries included [bytes]."""
READ = f"""
import resource, sys
from pathlib import Path
resource.setrlimit(resource.RLIMIT_AS, ({MEMORY}, {MEMORY}))
from recordings.reader import read
recording = read(Path(sys.argv[1]))
print(len(recording.time), recording.time[-1], recording.gaps.sum())
"""


def record_a_second(path: Path, rig: Rig, run: Run) -> None:
    """Write a second at rest, with the frames of three drives: what moves packs worse, further from the limit."""
    rng = np.random.default_rng(0)
    with RecordingWriter(path, rig, run) as writer:
        for k in range(RATE):
            stamp, counts = START_NS + k * 10**9 // RATE, rng.integers(-1, 2, size=(2, 3))
            writer.can(stamp, stamp, 0x80, b"", sent=True)
            for node, (position, volts) in enumerate(counts.T, start=1):
                writer.can(stamp, stamp, 0x200 + node, bytes(6), sent=True)
                writer.can(stamp, stamp, 0x180 + node, struct.pack("<ii", position, volts), sent=False)
            writer.joint_states(stamp, stamp, 4e-5 * counts[0])
            writer.joint_commands(stamp, stamp, [0.0] * 3)
            writer.amplifiers(stamp, stamp, k, 0, 0.0, 5e-4 * counts[1], [0] * 3, [0] * 3)


def seconds(path: Path) -> Iterator[bytes]:
    """The head of the file `path`, then its messages as one chunk with its index, again and again a second later."""
    with open_records(path) as stream:
        records = list(stream.records())
    yield path.read_bytes()[: next(offset for opcode, offset, _ in records if opcode == Opcode.CHUNK)]
    data = b"".join(unpacked(decode(Chunk.read, body)) for opcode, _, body in records if opcode == Opcode.CHUNK)
    messages, described = located(data)
    for opcode, body in described:
        yield RECORD.pack(opcode, len(body)) + body
    parts = {key: rows(data, key[1], offsets) for key, offsets in messages.items()}
    ends = dict(zip(parts, accumulate(part.size for part in parts.values()), strict=True))
    for _ in range(SECONDS):
        data = b"".join(parts.values())
        packed = zstandard.compress(data, 1)
        chunk = struct.pack("<QQQII4sQ", 0, 0, len(data), zlib.crc32(data), 4, b"zstd", len(packed)) + packed
        yield RECORD.pack(Opcode.CHUNK, len(chunk)) + chunk
        for key, part in parts.items():
            entries = np.zeros((len(part), 2), "<u8")  # log time and offset
            entries[:, 1] = np.arange(ends[key] - part.size, ends[key], part.shape[1])
            body = struct.pack("<HI", key[0], entries.nbytes) + entries.tobytes()
            yield RECORD.pack(Opcode.MESSAGE_INDEX, len(body)) + body
            part[:, : MESSAGE_HEAD.itemsize].view(MESSAGE_HEAD)["log"] += np.uint64(10**9)
            part[:, STAMP].view("<i4")[:] += 1


def test_hour_at_a_kilohertz_with_its_frames_is_read(tmp_path: Path, rig: Rig, run: Run) -> None:
    record_a_second(tmp_path / "second.mcap", rig, run)
    hour = tmp_path / "hour.mcap"
    with hour.open("wb") as file:
        file.writelines(seconds(tmp_path / "second.mcap"))
    answer = subprocess.run([sys.executable, "-c", READ, hour], capture_output=True, text=True, check=False)
    hour.unlink()
    assert answer.stdout.split() == [str(RATE * SECONDS), str(SECONDS - 1 / RATE), "0"], answer.stderr
