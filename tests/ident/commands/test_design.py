"""`ident design` as a user types it."""

import json
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from ident.program import program
from recordings.recording import Recording
from recordings.rig import load_rig
from tests.ident import building
from tests.running import ran
from trajectories import load
from trajectories.checks import check

BENCH = """
name = "bench"
mechanism = "axes"
[[axes]]
[limits]
joint_min = -0.5
joint_max = 0.9
speed = 3.0
acceleration = 25.0
"""


@pytest.fixture
def rig(tmp_path: Path) -> Path:
    path = tmp_path / "bench.toml"
    path.write_text(BENCH)
    return path


design = partial(ran, program, "design")


def test_writes_a_trajectory_and_prints_the_expected_errors(rig: Path, tmp_path: Path) -> None:
    out = tmp_path / "best.toml"
    result = design("--rig", rig, "--harmonics", 2, "-o", out, "--with", "torque_offset")
    for text in ("condition number", "I_1", "torque_offset.a1", "kg m^2", "acceleration", "%"):
        assert text in result.stdout
    assert f"next: daq record --traj {out} --rig {rig}" in result.stderr
    bench = load_rig(rig, driven=False)
    check(load(out, bench), bench)
    design("--rig", rig, "--harmonics", 1, "-o", out, "--force")


def test_json_compares_with_another_motion(rig: Path, tmp_path: Path) -> None:
    first, second = tmp_path / "first.toml", tmp_path / "second.toml"
    design("--rig", rig, "--harmonics", 1, "-o", first)
    result = design("--rig", rig, "--harmonics", 2, "--against", first, "-o", second, "--json")
    document = json.loads(result.stdout)
    assert (document["schema"], document["trajectory"], document["against"]) == (1, "second.toml", str(first))
    before, after = document["before"], document["after"]
    assert set(before) == {"condition_number", "standard_errors", "limits", "discrimination"}
    assert before["discrimination"] is None  # no effects to discriminate
    assert set(after["standard_errors"]) == {"I_1", "c_v1", "c_c1"}
    assert max(after["limits"].values()) <= 0.96


def test_the_same_seed_gives_the_same_bytes(rig: Path, tmp_path: Path) -> None:
    files = [tmp_path / f"{i}.toml" for i in range(3)]
    for path, seed in zip(files, (3, 3, 4), strict=True):
        design("--rig", rig, "--harmonics", 2, "--seed", seed, "-o", path)
    assert files[0].read_bytes() == files[1].read_bytes() != files[2].read_bytes()


def test_the_rig_of_an_import_is_a_placeholder_that_says_so(
    write: Callable[[Recording], Path], tmp_path: Path
) -> None:
    file = write(replace(building.record(noise=0.05), path=tmp_path / "imported.mcap"))
    out = tmp_path / "best.toml"
    result = design("--recording", file, "--harmonics", 1, "-o", out)
    lines = ["RIG.toml stands for the rig file of your robot", f"next: daq record --traj {out} --rig RIG.toml"]
    assert result.stderr.splitlines()[-2:] == lines, result.output
