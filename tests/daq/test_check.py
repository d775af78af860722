"""`daq check` as a user runs it."""

import json
from pathlib import Path

import pytest

from tests.conftest import Runner
from tests.running import free_port

RIG = """
name = "bench"
[[drives]]
node_id = 1
{}
[[drives]]
node_id = 2
[[drives]]
node_id = 3
"""


def test_simulated_drives_have_no_problems_and_values_to_write_are_listed(daq: Runner) -> None:
    done = daq("check", "--json")
    assert done.code == 0, done.err
    document = json.loads(done.out)
    assert [drive["address"] for drive in document["drives"]] == ["node 1", "node 2", "node 3"]
    verdicts = {(f["where"], f["what"].split()[0]): f for f in document["findings"]}
    watchdog = verdicts["joint 1 (node 1)", "1016:01"]
    assert watchdog["verdict"] == "will be written"
    assert int(watchdog["expected"]) == 127 << 16 | 250
    assert "40% loaded" in document["bus"]


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("homed = { index = 0x2F00, sub = 9 }", "zero reference"),
        ("voltage = { index = 0x2300 }", "voltage object"),
        ('voltage = { kind = "dc_link" }', "DC link"),
    ],
)
def test_problem_is_named_and_the_command_fails(line: str, problem: str, daq: Runner, tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text(RIG.format(line))
    done = daq("check", "--rig", "rig.toml", "--json")
    assert done.code == 1
    problems = [f for f in json.loads(done.out)["findings"] if f["verdict"] == "problem"]
    assert problems
    assert all(f["where"] == "joint 1 (node 1)" for f in problems)
    assert any(problem in f["what"] + f["found"] for f in problems)


def test_joints_outside_their_limits_are_a_problem(daq: Runner, tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text(RIG.format("") + "[limits]\njoint_min = 0.0\n")
    done = daq("check", "--rig", "rig.toml", "--json")
    assert done.code == 1
    problems = [f for f in json.loads(done.out)["findings"] if f["verdict"] == "problem"]
    assert [f["what"] for f in problems] == ["joint angle"] * 3
    assert problems[0]["found"].startswith("-0.32")


def test_table_groups_equal_results(daq: Runner) -> None:
    done = daq("check")
    assert done.code == 0
    assert "joints 1, 2, 3" in done.out
    assert "written and read back" in done.out


def test_missing_drives_are_named(daq: Runner, tmp_path: Path) -> None:
    bus = f'[bus]\ninterface = "udp_multicast"\nchannel = "239.74.163.2"\nport = {free_port()}\n'
    (tmp_path / "rig.toml").write_text(RIG.format("") + bus)
    done = daq("check", "--rig", "rig.toml")
    assert done.code == 1
    assert "no answer from joint 1 (node 1), joint 2 (node 2), joint 3 (node 3)" in done.err
