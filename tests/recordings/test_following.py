"""Reading a recording piece by piece gives what reading it at once does, also while it is written."""

import io
from pathlib import Path

import numpy as np
import pytest

from recordings.errors import BadInput
from recordings.following import pieces
from recordings.reader import read
from recordings.recording import Recording

SAMPLE = Path(__file__).parents[2] / "recordings" / "samples" / "fig5a.mcap"


def assert_all_of(found: list[Recording], expected: Recording) -> None:
    for name in ("time", "position", "command", "voltage", "statusword", "repeat"):
        joined = np.concatenate([getattr(piece, name) for piece in found])
        np.testing.assert_array_equal(joined, getattr(expected, name))
    assert found[0].rig == expected.rig


def test_pieces_are_the_whole_recording() -> None:
    with SAMPLE.open("rb") as file:
        found = list(pieces(file, SAMPLE))
    assert len(found) > 10
    assert_all_of(found, read(SAMPLE))


def test_interrupted_recording_ends_with_what_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "cut.mcap"
    path.write_bytes(SAMPLE.read_bytes()[: SAMPLE.stat().st_size // 2])
    with path.open("rb") as file:
        assert_all_of(list(pieces(file, path)), read(path))


def test_file_that_grows_is_followed_to_its_end(tmp_path: Path) -> None:
    path, content = tmp_path / "growing.mcap", SAMPLE.read_bytes()
    starts = iter(range(0, len(content), 50_000))

    def growing() -> bool:
        start = next(starts)
        with path.open("ab") as file:
            file.write(content[start : start + 50_000])
        return True

    path.touch()
    with path.open("rb") as file:
        assert_all_of(list(pieces(file, path, growing=growing)), read(SAMPLE))


@pytest.mark.parametrize(
    ("content", "message"),
    [(b"", "not an MCAP file"), (b"no", "not an MCAP file"), (SAMPLE.read_bytes()[:8], "cut off before")],
)
def test_what_is_no_recording_is_refused(content: bytes, message: str) -> None:
    with pytest.raises(BadInput, match=message):
        list(pieces(io.BytesIO(content), Path("x.mcap")))


def test_damage_is_refused() -> None:
    content = bytearray(SAMPLE.read_bytes())
    content[len(content) // 2] ^= 0xFF
    with pytest.raises(BadInput, match="is damaged"):
        list(pieces(io.BytesIO(content), Path("x.mcap")))
