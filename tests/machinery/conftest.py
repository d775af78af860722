"""Planted tests, which pytest runs in another process with the hooks of tests/conftest.py."""

import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.patience import patient

_ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Ran:
    """A run of planted tests."""

    code: int
    out: str
    passed: set[str]


@dataclass(frozen=True)
class Planted:
    """A folder of tests."""

    folder: Path

    @property
    def handed(self) -> Path:
        """Where failures are handed to."""
        return self.folder / "handed"

    def write(self, name: str, text: str) -> None:
        """Plant a module."""
        (self.folder / f"{name}.py").write_text(text)

    def run(self, *options: str) -> Ran:
        """Run all of them."""
        command = [sys.executable, "-m", "pytest", "-q", "-rA", "-c", str(self.folder / "pytest.ini"), *options]
        without = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST", "TEST_"))}
        done = subprocess.run(
            [*command, str(self.folder)], cwd=_ROOT, env=without, capture_output=True, text=True, timeout=patient(120)
        )
        return Ran(
            done.returncode, done.stdout + done.stderr, set(re.findall(r"(?m)^PASSED (?:\S*/)?(\S+)", done.stdout))
        )


@pytest.fixture
def planted(tmp_path: Path) -> Planted:
    """An empty folder of tests."""
    markers = "slow essential realtime vcan".replace(" ", "\n    ")
    (tmp_path / "pytest.ini").write_text(
        f"[pytest]\nmarkers =\n    {markers}\naddopts = -p no:cacheprovider --import-mode=importlib\n"
    )
    (tmp_path / "conftest.py").write_text("from tests.conftest import *\n")
    return Planted(tmp_path)
