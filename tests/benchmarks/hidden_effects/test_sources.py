"""Digests of the sources and of the commit."""

import subprocess
from pathlib import Path

import pytest

from benchmarks.hidden_effects import sources


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """A folder with one source file."""
    (tmp_path / "ident").mkdir()
    (tmp_path / "ident" / "fit.py").write_text("x = 1\n")
    return tmp_path


def commit(root: Path) -> str:
    """Commit all files below `root`; return the digest of the commit."""
    for arguments in (
        ["init", "--quiet"],
        ["add", "."],
        ["-c", "user.name=a", "-c", "user.email=a@b", "commit", "--quiet", "-m", "All"],
    ):
        subprocess.run(["git", *arguments], cwd=root, check=True)
    done = subprocess.run(["git", "rev-parse", "HEAD"], cwd=root, check=True, capture_output=True, text=True)
    return done.stdout.strip()


def test_digest_depends_on_names_and_contents_of_the_packages(root: Path) -> None:
    before = sources.digest(["ident"], root)
    (root / "other.py").write_text("y = 1\n")
    assert sources.digest(["ident"], root) == before
    (root / "ident" / "fit.py").rename(root / "ident" / "refit.py")
    renamed = sources.digest(["ident"], root)
    (root / "ident" / "refit.py").write_text("x = 2\n")
    assert len({before, renamed, sources.digest(["ident"], root)}) == 3


def test_clean_commit_has_its_own_digest(root: Path) -> None:
    assert commit(root).startswith(sources.commit(root))
    assert len(sources.commit(root)) == 12


def test_without_repository_the_sources_have_a_digest(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(root.parent))
    assert sources.commit(root) == sources.digest(root=root)
