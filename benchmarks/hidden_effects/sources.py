"""Digests that identify the version of the sources."""

import hashlib
import subprocess
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).parents[2]
_ALL = ("benchmarks", "daq", "drivers", "ident", "recordings", "tests/foreign", "trajectories")
"""Packages that a result of the benchmark depends on."""
_LENGTH = 12


def digest(packages: Sequence[str] = _ALL, root: Path = ROOT) -> str:
    """Digest of the Python files of `packages`."""
    content = hashlib.sha256()
    for path in sorted(path for package in packages for path in (root / package).rglob("*.py")):
        content.update(str(path.relative_to(root)).encode() + path.read_bytes())
    return content.hexdigest()[:_LENGTH]


def commit(root: Path = ROOT) -> str:
    """Digest of the commit; that of the sources where there is no commit, or where files differ from it."""
    try:
        if not _git(root, "status", "--porcelain"):
            return _git(root, "rev-parse", "HEAD")[:_LENGTH]
    except (OSError, subprocess.CalledProcessError):
        pass
    return digest(root=root)


def _git(root: Path, *arguments: str) -> str:
    done = subprocess.run(["git", *arguments], cwd=root, check=True, capture_output=True, text=True)
    return done.stdout.strip()
