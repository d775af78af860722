"""The digest is that of the whole content."""

import hashlib
from pathlib import Path

import pytest

from recordings.errors import BadInput
from recordings.files import create, sha256


def test_digest_is_the_sha_256_of_the_bytes(tmp_path: Path) -> None:
    path = tmp_path / "a.bin"
    path.write_bytes(b"\0abc" * 300_000)
    assert sha256(path) == hashlib.sha256(path.read_bytes()).hexdigest()


def test_folder_that_takes_no_files_is_not_said_to_be_missing() -> None:
    with pytest.raises(BadInput, match="folder /proc takes no new files; choose another one for recording /proc/x"):
        create(Path("/proc/x.mcap"))
