"""`daq jog` as a user runs it on the simulated rig."""

import json
import subprocess
from pathlib import Path

import pytest

from recordings.reader import read
from tests.conftest import Runner, launcher


def test_jog_moves_one_joint_and_leaves_the_drives_off(daq: Runner, tmp_path: Path) -> None:
    done = daq("jog", "--joint", 2, "--by", 0.05, "--rate", 100, "--out", "jog.mcap", "--json")
    assert done.code == 0, done.err
    figures = json.loads(done.out)
    assert figures["to"] - figures["from"] == pytest.approx(0.05, abs=2e-3)
    recording = read(tmp_path / "jog.mcap")
    assert recording.run.trajectory == "jog-2"
    assert not (recording.statusword[-1] & 0x4).any()
    assert "next: daq axis-check --joint 2" in done.err


def test_closed_input_is_a_released_key(tmp_path: Path) -> None:
    command = [*launcher("daq"), "jog", "--joint", "2", "--by", "0.05", "--hold", "--json"]
    done = subprocess.run(command, cwd=tmp_path, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    figures = json.loads(done.stdout)
    assert figures["released"]
    assert figures["to"] == pytest.approx(figures["from"], abs=1e-3)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["--joint", 4, "--by", 0.1], "--joint: 1 to 3 expected, 4 found"),
        (["--joint", 1, "--by", 0], "a way expected"),
        (["--joint", 1, "--by", 0.5, "--rig", "tight.toml"], "limits.joint_min or joint_max"),
        (["--joint", 1, "--by", 0.1, "--rig", "axis.toml"], "the simulated machine is a delta robot"),
    ],
)
def test_bad_input_moves_nothing(
    arguments: list[object], expected: str, daq_in_process: Runner, tmp_path: Path
) -> None:
    drives = "".join(f"[[drives]]\nnode_id = {i}\n" for i in (1, 2, 3))
    (tmp_path / "tight.toml").write_text(
        f'name = "tight"\nrate = 100\n[bus]\ninterface = "virtual"\n[limits]\njoint_max = -0.1\n{drives}'
    )
    (tmp_path / "axis.toml").write_text(
        'name = "axis"\nmechanism = "axes"\n[[axes]]\n[bus]\ninterface = "virtual"\n[[drives]]\nnode_id = 1\n'
    )
    done = daq_in_process("jog", *arguments, "--out", "jog.mcap")
    assert done.code == 2
    assert expected in done.err
    assert not (tmp_path / "jog.mcap").exists()
