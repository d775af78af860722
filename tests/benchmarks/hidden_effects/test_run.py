"""Command of the benchmark: record, diagnose, score, and continue after a stop."""

import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.hidden_effects.cases import cases

HERE = Path(__file__).parents[3]


def run(folder: Path, *arguments: str) -> str:
    command = [sys.executable, "-m", "benchmarks.hidden_effects", "--plant", "foreign", "--folder", str(folder)]
    done = subprocess.run([*command, *arguments], cwd=HERE, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
def test_finished_cases_are_not_repeated(tmp_path: Path) -> None:
    only = next(case.name for case in cases("foreign") if case.kind == "nothing" and case.rate <= 250)
    assert "record 1/1" in run(tmp_path, "--only", only, "--stage", "record")
    assert "record" not in run(tmp_path, "--only", only, "--stage", "record")
    first = run(tmp_path, "--only", only)
    assert "diagnose 1/1" in first
    assert "1 cases" in first
    again = run(tmp_path, "--only", only)
    assert "diagnose 1/1" not in again
    assert "nothing hidden: adequate" in again
