"""What all rooms' tests share: running the programs as a user does."""

import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# Programs that compile side by side must not write into one cache: of two that compile one function for different
# arguments, the later overwrites the earlier one's code. So every worker of pytest-xdist has its own, which stays.
if (_worker := os.environ.get("PYTEST_XDIST_WORKER")) is not None:
    os.environ["NUMBA_CACHE_DIR"] = str(Path(__file__).parents[1] / ".pytest_cache" / "numba" / _worker)

# What decides whether a change lands is the same each time; at a desk, examples are drawn anew.
# How long an example takes, says nothing on a machine that does other things, too.
_ANY_SPEED = {"deadline": None, "suppress_health_check": [HealthCheck.too_slow]}
settings.register_profile("desk", **_ANY_SPEED)
settings.register_profile("ci", derandomize=True, **_ANY_SPEED)
settings.load_profile("ci" if os.environ.get("CI") == "true" else "desk")


@dataclass(frozen=True)
class Finished:
    """What a command left behind."""

    code: int
    out: str
    err: str


Runner = Callable[..., Finished]


def launcher(program: str) -> list[str]:
    """The start of a command line that runs `daq` or `ident` of this checkout."""
    return [sys.executable, "-W", "error", "-c", f"from {program}.cli import main; main()"]


def _runner(program: str, folder: Path) -> Runner:
    def run(*arguments: object, timeout: float = 900) -> Finished:
        done = subprocess.run(
            [*launcher(program), *map(str, arguments)], cwd=folder, capture_output=True, text=True, timeout=timeout
        )
        assert "Traceback" not in done.stderr, done.stderr
        return Finished(done.returncode, done.stdout, done.stderr)

    return run


@pytest.fixture
def daq(tmp_path: Path) -> Runner:
    """Run `daq` in a folder of its own."""
    return _runner("daq", tmp_path)


@pytest.fixture
def ident(tmp_path: Path) -> Runner:
    """Run `ident` in a folder of its own."""
    return _runner("ident", tmp_path)
