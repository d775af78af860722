"""Compare the speed of this project's reader with mcap-ros2-support on the same file."""

import math
import tempfile
import timeit
from collections.abc import Callable
from pathlib import Path

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from benchmarks.programs import claim, timed
from recordings.reader import read, read_can
from recordings.recording import Run
from recordings.rig import simulated_rig
from recordings.writer import RecordingWriter

SECONDS = 10
RATE = 500


def make(path: Path) -> None:
    """Write a recording as `daq record` does: seven frames and four messages per SYNC."""
    run = Run(
        trajectory="benchmark",
        trajectory_digest="",
        period=float(SECONDS),
        cycles=1,
        rate=float(RATE),
        software="benchmark",
        simulated=True,
        pace="lockstep",
        start="1970-01-01T00:00:00+00:00",
    )
    with RecordingWriter(path, simulated_rig(), run) as writer:
        for k in range(SECONDS * RATE):
            stamp = k * 10**9 // RATE
            position = [0.3 * math.sin(k / 100 + joint) for joint in range(3)]
            counts = [int(27_000 * angle).to_bytes(4, "little", signed=True) for angle in position]
            writer.can(stamp, stamp, 0x80, b"", sent=True)
            for joint in range(3):
                writer.can(stamp, stamp, 0x201 + joint, b"\x1f\x00" + counts[joint], sent=True)
                writer.can(stamp, stamp, 0x181 + joint, b"\x37\x12" + counts[joint] + b"\x10\x01", sent=False)
            writer.joint_states(stamp, stamp, position)
            writer.joint_commands(stamp, stamp, position)
            writer.amplifiers(stamp, stamp, k, 0, 1e-4, position, (0x1237,) * 3, (0,) * 3)
            writer.platform_reference(stamp, stamp, (0.1, 0.2, -0.8))


def ours(path: Path) -> int:
    """Read the file with `read` and `read_can`; return the number of decoded messages."""
    recording, frames = read(path), read_can(path)
    return 3 * len(recording.time) + len(frames.id)


def mcap_ros2_support(path: Path) -> int:
    """Decode the same topics message by message; return the number of messages."""
    topics = ["/joint_states", "/joint_commands", "/amplifiers", "/can"]
    with path.open("rb") as stream:
        decoded = make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages(topics=topics)
        return sum(1 for _ in decoded)


def rate(reader: Callable[[Path], int], path: Path, repeats: int = 3) -> float:
    """Messages per second, the best of `repeats`."""
    return reader(path) / min(timeit.repeat(lambda: reader(path), number=1, repeat=repeats))


def main() -> None:
    """Print both rates and their ratio."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "benchmark.mcap"
        _, elapsed = timed(lambda: make(path))
        print(
            f"writing: {11 * SECONDS * RATE / elapsed:,.0f} messages/s, {path.stat().st_size / SECONDS:,.0f} bytes/s"
        )
        our_rate, library_rate = rate(ours, path), rate(mcap_ros2_support, path)
        print(
            f"reading: {our_rate:,.0f} messages/s, mcap-ros2-support {library_rate:,.0f} messages/s, "
            f"ratio {our_rate / library_rate:.1f}"
        )
        claim("reading is faster than mcap-ros2-support", our_rate > library_rate)


if __name__ == "__main__":
    main()
