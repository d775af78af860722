"""Command of the benchmark: record, diagnose, score, and continue after a stop."""

import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.hidden_effects.cases import Part
from benchmarks.hidden_effects.parts import cases
from tests.patience import patient

HERE = Path(__file__).parents[3]


def run(folder: Path, *arguments: str) -> str:
    command = [sys.executable, "-m", "benchmarks.hidden_effects", "--plant", "foreign", "--folder", str(folder)]
    done = subprocess.run([*command, *arguments], cwd=HERE, capture_output=True, text=True, timeout=patient(900))
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
def test_finished_cases_are_not_repeated_and_parts_stand_side_by_side(tmp_path: Path) -> None:
    lock = "0123456789ab"
    parts: tuple[Part, ...] = "tuned", "locked"
    tuned, locked = (
        next(case.name for case in cases("foreign", part, lock) if case.kind == "nothing" and case.rate <= 250)
        for part in parts
    )
    options = ["--only", tuned, "--only", locked, "--lock", lock]
    assert "record 1/1" in run(tmp_path, *options, "--stage", "record")
    assert "record" not in run(tmp_path, *options, "--stage", "record")
    first = run(tmp_path, *options)
    assert "diagnose 1/1" in first
    assert "tuned: 1 cases" in first
    both = run(tmp_path, *options, "--part", "locked")
    assert both.count("diagnose 1/1") == 1
    header = next(line for line in both.splitlines() if "required" in line)
    assert header.split() == ["required", "tuned", "locked"]
    assert "nothing hidden: no finding, right verdict" in both
    again = run(tmp_path, *options, "--part", "locked")
    assert both.endswith(again)


def test_simulated_rig_has_no_other_part(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "benchmarks.hidden_effects", "--part", "locked", "--folder", str(tmp_path)]
    done = subprocess.run(command, cwd=HERE, capture_output=True, text=True, timeout=patient(60))
    assert done.returncode == 2
    assert "use --plant foreign" in done.stderr
