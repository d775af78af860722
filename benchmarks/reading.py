"""Compare the speed of this project's reader with mcap-ros2-support on the same file."""

import tempfile
import timeit
from functools import partial
from pathlib import Path

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from benchmarks.programs import claim, record_demo
from recordings.reader import read, read_can


def ours(path: Path) -> None:
    """Read the signals and the frames of a recording."""
    read(path)
    read_can(path)


def mcap_ros2_support(path: Path) -> int:
    """Decode the same topics message by message; return the number of messages."""
    topics = ["/joint_states", "/joint_commands", "/amplifiers", "/can"]
    with path.open("rb") as stream:
        decoded = make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages(topics=topics)
        return sum(1 for _ in decoded)


def main() -> None:
    """Print both rates and their ratio."""
    with tempfile.TemporaryDirectory() as folder:
        path = record_demo(Path(folder), "fig5a")
        messages = mcap_ros2_support(path)
        our_rate, library_rate = (
            messages / min(timeit.repeat(partial(reader, path), number=1, repeat=3))
            for reader in (ours, mcap_ros2_support)
        )
    print(
        f"reading: {our_rate:,.0f} messages/s, mcap-ros2-support {library_rate:,.0f} messages/s, "
        f"ratio {our_rate / library_rate:.1f}"
    )
    claim("reading is faster than mcap-ros2-support", our_rate > library_rate)


if __name__ == "__main__":
    main()
