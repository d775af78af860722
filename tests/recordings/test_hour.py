"""An hour at 1 kHz with its CAN frames opens within the limits of files of strangers."""

import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from recordings import schemas
from recordings.blocks import message_types
from recordings.container import load
from recordings.container_writer import ContainerWriter, pack
from recordings.files import new_file
from recordings.metadata import rig_record, run_record
from recordings.recording import Run
from recordings.rig import Rig
from recordings.writer import RecordingWriter

pytestmark = pytest.mark.slow

RATE, SECONDS = 1000, 3600
START_NS = 1_700_000_000_000_000_000
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


def write_an_hour(path: Path, second: Path, rig: Rig, run: Run) -> None:
    """The messages of the recording `second` as one chunk, again and again a second later."""
    batches = [batch.copy() for of_topic in load(second, schemas.TOPICS).batches.values() for batch in of_topic]
    with new_file(path) as stream:
        writer = ContainerWriter(stream)
        writer.metadata("rig", rig_record(rig))
        writer.metadata("run", run_record(run))
        for types in message_types():
            writer.describe(*types)
        for _ in range(SECONDS):
            writer.chunk(pack(batches))
            for batch in batches:
                batch["log"] += np.uint64(10**9)
                batch["message"]["header.stamp"]["sec"] += 1
        writer.finish()


def test_hour_at_a_kilohertz_with_its_frames_is_read(tmp_path: Path, rig: Rig, run: Run) -> None:
    record_a_second(tmp_path / "second.mcap", rig, run)
    hour = tmp_path / "hour.mcap"
    write_an_hour(hour, tmp_path / "second.mcap", rig, run)
    answer = subprocess.run([sys.executable, "-c", READ, hour], capture_output=True, text=True, check=False)
    hour.unlink()
    assert answer.stdout.split() == [str(RATE * SECONDS), str(SECONDS - 1 / RATE), "0"], answer.stderr
