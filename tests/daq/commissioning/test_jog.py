"""`daq jog` as a user runs it on the simulated rig."""

import json
import subprocess
from pathlib import Path

import pytest

from recordings.reader import read
from tests.conftest import Runner, launcher


def test_jog_moves_one_joint_and_leaves_the_drives_off(daq_in_process: Runner, tmp_path: Path) -> None:
    done = daq_in_process("jog", "--joint", 2, "--by", 0.05, "--rate", 100, "--out", "jog.mcap", "--json")
    figures = done.figures
    assert figures["to"] - figures["from"] == pytest.approx(0.05, abs=2e-3)
    recording = read(tmp_path / "jog.mcap")
    assert recording.run.trajectory == "jog-2"
    assert not (recording.statusword[-1] & 0x4).any()
    assert "next: daq axis-check --joint 2" in done.err


def test_what_comes_next_is_on_the_same_simulated_machine(daq_in_process: Runner) -> None:
    done = daq_in_process("jog", "--joint", 2, "--by", 0.05, "--rate", 100, "--sim", "light")
    assert "next: daq axis-check --joint 2 --sim light" in done.err


def test_closed_input_is_a_released_key(tmp_path: Path) -> None:
    command = [*launcher("daq"), "jog", "--joint", "2", "--by", "0.05", "--rate", "100", "--hold", "--json"]
    done = subprocess.run(command, cwd=tmp_path, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    figures = json.loads(done.stdout)
    assert figures["released"]
    assert figures["to"] == pytest.approx(figures["from"], abs=1e-3)
    assert list(tmp_path.iterdir()) == []
