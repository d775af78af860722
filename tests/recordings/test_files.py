"""The digest is that of the whole content."""

import hashlib
from pathlib import Path

from recordings.files import sha256


def test_digest_is_the_sha_256_of_the_bytes(tmp_path: Path) -> None:
    path = tmp_path / "a.bin"
    path.write_bytes(b"\0abc" * 300_000)
    assert sha256(path) == hashlib.sha256(path.read_bytes()).hexdigest()
