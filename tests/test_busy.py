"""A command beside busy processes, and how much longer deadlines are then."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.patience import measured

HERE = Path(__file__).parents[1]


def test_command_runs_beside_busy_processes_that_end_with_it() -> None:
    told = "import os, sys; print(os.getppid()); sys.exit(3)"
    command = [sys.executable, "-m", "tests.busy", "2", "--", sys.executable, "-c", told]
    done = subprocess.run(command, cwd=HERE, capture_output=True, text=True, check=False)
    assert done.returncode == 3, done.stderr
    stats = [path.read_text() for path in Path("/proc").glob("[0-9]*/stat") if path.exists()]
    assert not [stat for stat in stats if stat.rpartition(")")[2].split()[1] == done.stdout.strip()]


@pytest.mark.parametrize("words", [[], ["2"], ["x", "--", "true"], ["2", "true", "false"]])
def test_what_is_no_command_is_explained(words: list[str]) -> None:
    command = [sys.executable, "-m", "tests.busy", *words]
    done = subprocess.run(command, cwd=HERE, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "expected: python -m tests.busy COUNT -- COMMAND" in done.stderr


def test_patience_is_between_1_and_10() -> None:
    assert 1.0 <= measured(0.1) <= 10.0
