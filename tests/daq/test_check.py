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


def test_simulated_drives_have_no_problems_and_values_to_write_are_listed(daq_in_process: Runner) -> None:
    done = daq_in_process("check", "--json")
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
def test_problem_is_named_and_the_command_fails(
    line: str, problem: str, daq_in_process: Runner, tmp_path: Path
) -> None:
    (tmp_path / "rig.toml").write_text(RIG.format(line))
    done = daq_in_process("check", "--rig", "rig.toml", "--json")
    assert done.code == 1
    problems = [f for f in json.loads(done.out)["findings"] if f["verdict"] == "problem"]
    assert problems
    assert all(f["where"] == "joint 1 (node 1)" for f in problems)
    assert any(problem in f["what"] + f["found"] for f in problems)


def test_joints_outside_their_limits_are_a_problem(daq_in_process: Runner, tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text(RIG.format("") + "[limits]\njoint_min = 0.0\n")
    done = daq_in_process("check", "--rig", "rig.toml", "--json")
    assert done.code == 1
    problems = [f for f in json.loads(done.out)["findings"] if f["verdict"] == "problem"]
    assert [f["what"] for f in problems] == ["joint angle"] * 3
    assert problems[0]["found"].startswith("-0.32")


def test_table_groups_equal_results(daq_in_process: Runner) -> None:
    done = daq_in_process("check")
    assert done.code == 0
    assert "joints 1, 2, 3" in done.out
    assert "written and read back" in done.out


def test_missing_drives_are_named(daq_in_process: Runner, tmp_path: Path) -> None:
    bus = f'[bus]\ninterface = "udp_multicast"\nchannel = "239.74.163.2"\nport = {free_port()}\n'
    (tmp_path / "rig.toml").write_text(RIG.format("") + bus)
    done = daq_in_process("check", "--rig", "rig.toml")
    assert done.code == 1
    assert "no answer from joint 1 (node 1), joint 2 (node 2), joint 3 (node 3)" in done.err


HABIT = """
[[drives]]
habits = { %s }
"""


def check(daq: Runner, folder: Path, habits: str, keys: str = "", *options: str) -> tuple[int, list[dict[str, str]]]:
    """Exit code and findings of `daq check` with three drives of these habits and keys of the rig file."""
    (folder / "rig.toml").write_text("".join(f"[[drives]]\nnode_id = {node}\n{keys}\n" for node in (1, 2, 3)))
    text = (folder / "rig.toml").read_text()
    (folder / "rig.toml").write_text(f'name = "bench"\n{text}')
    (folder / "sim.toml").write_text(HABIT % habits)
    done = daq("check", "--rig", "rig.toml", "--sim", "sim.toml", "--json", *options)
    return done.code, json.loads(done.out)["findings"]


def found(findings: list[dict[str, str]], what: str) -> dict[str, str]:
    """The finding of joint 1 whose subject begins with `what`."""
    return next(f for f in findings if f["what"].startswith(what) and f["where"] == "joint 1 (node 1)")


def test_drive_in_fault_is_a_problem_with_code_text_and_what_to_do(daq_in_process: Runner, tmp_path: Path) -> None:
    code, findings = check(daq_in_process, tmp_path, "fault_at_power_on = 0x3220")
    assert code == 1
    state = found(findings, "state")
    assert state["verdict"] == "problem"
    assert "0x3220: DC link under-voltage" in state["found"]
    assert "remove its cause" in state["found"]


def test_state_mode_supply_and_units_are_shown(daq_in_process: Runner, tmp_path: Path) -> None:
    code, findings = check(daq_in_process, tmp_path, "")
    assert code == 0
    assert found(findings, "mode that the drive shows")["found"] == "0"
    assert "48 V" in found(findings, "supply")["found"]
    assert found(findings, "1 rad/s^2 of the joint")["found"] == "27379.7 counts/s^2 (60AAh)"
    assert found(findings, "6085:00")["expected"] == "4106961 = 150 rad/s^2"


def test_limits_are_shown_as_the_drive_understands_them(daq_in_process: Runner, tmp_path: Path) -> None:
    code, findings = check(daq_in_process, tmp_path, 'values = { "60AA" = 0x00C00300 }')
    assert code == 0
    # 150 rad/s^2 times 21 * 60 / (2 pi) rpm/s; the drive has 1,000,000.
    assert found(findings, "6085:00")["expected"] == "30080 = 150 rad/s^2"
    assert found(findings, "6085:00")["found"] == "1000000 = 4987 rad/s^2"


def test_contradiction_of_units_is_a_problem_with_both_numbers(daq_in_process: Runner, tmp_path: Path) -> None:
    keys = 'units = { acceleration = "counts/s^2" }'
    code, findings = check(daq_in_process, tmp_path, 'values = { "60AA" = 0x00C00300 }', keys)
    assert code == 1
    text = found(findings, "1 rad/s^2 of the joint")
    assert text["verdict"] == "problem"
    assert "200.535 by the drive" in text["found"]
    assert "27379.7 by units.acceleration" in text["found"]


def test_unknown_unit_of_velocity_is_noted(daq_in_process: Runner, tmp_path: Path) -> None:
    code, findings = check(daq_in_process, tmp_path, 'values = { "60A9" = 0x00123456 }')
    assert code == 0
    assert "0x00123456 is unknown" in found(findings, "unit of velocity")["found"]


def test_refused_value_is_known_when_it_is_written(daq_in_process: Runner, tmp_path: Path) -> None:
    habits = 'allowed = { "605A" = [6] }, values = { "605A" = 6 }'
    assert check(daq_in_process, tmp_path, habits)[0] == 0
    code, findings = check(daq_in_process, tmp_path, habits, "", "--set-up")
    assert code == 1
    assert "quick_stop_option" in findings[-1]["found"]
    assert check(daq_in_process, tmp_path, habits, "quick_stop_option = 6", "--set-up")[0] == 0


def test_mask_of_the_statusword(daq_in_process: Runner, tmp_path: Path) -> None:
    keys = "homed = { index = 0x6041, mask = 0x8000 }"
    assert check(daq_in_process, tmp_path, "referenced_mask = 0x8000", keys)[0] == 0
    code, findings = check(daq_in_process, tmp_path, "", keys)
    assert code == 1
    assert found(findings, "zero reference")["verdict"] == "problem"


def test_mask_beyond_16_bits_of_the_statusword_is_refused(daq_in_process: Runner, tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text(RIG.format("homed = { index = 0x6041, mask = 0x10000 }"))
    done = daq_in_process("check", "--rig", "rig.toml")
    assert done.code == 2
    assert "16-bit statusword" in done.err
