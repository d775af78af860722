"""`daq check` as a user runs it."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from canopen.sdo import SdoClient

from tests.conftest import Runner
from tests.running import DRIVES, udp_bus

HOMED = "homed = { index = 0x6041, mask = 0x8000 }"
Check = Callable[..., tuple[int, list[dict[str, str]]]]


@pytest.fixture
def check(daq_in_process: Runner, tmp_path: Path) -> Check:
    """Exit code and findings of `daq check` with drives of these habits, keys of each, and sections of the rig."""

    def checked(habits: str = "", keys: str = "", *options: str, sections: str = "") -> tuple[int, Any]:
        drives = "".join(f"[[drives]]\nnode_id = {node}\n{keys}\n" for node in (1, 2, 3))
        (tmp_path / "rig.toml").write_text(f'name = "bench"\n{drives}{sections}')
        (tmp_path / "sim.toml").write_text(f"[[drives]]\nhabits = {{ {habits} }}\n")
        done = daq_in_process("check", "--rig", "rig.toml", "--sim", "sim.toml", "--json", *options)
        return done.code, json.loads(done.out)["findings"]

    return checked


def found(findings: list[dict[str, str]], what: str) -> dict[str, str]:
    """The finding of joint 1 whose subject begins with `what`."""
    return next(f for f in findings if f["what"].startswith(what) and f["where"] == "joint 1 (node 1)")


def test_simulated_drives_have_no_problems_and_equal_results_are_grouped(daq_in_process: Runner) -> None:
    document = json.loads(daq_in_process("check", "--json").out)
    assert [drive["address"] for drive in document["drives"]] == ["node 1", "node 2", "node 3"]
    watchdog = found(document["findings"], "1016:01")
    assert watchdog["verdict"] == "will be written"
    assert int(watchdog["expected"], 16) == 127 << 16 | 250
    assert "40% loaded" in document["bus"]
    done = daq_in_process("check")
    assert done.code == 0
    assert "joints 1, 2, 3" in done.out
    assert re.search(r"joint angle .* -0\.3256 rad +fine", done.out)
    assert "written and read back" in done.out


@pytest.mark.parametrize(
    ("habits", "keys", "sections", "what", "texts"),
    [
        ("", "homed = { index = 0x2F00, sub = 9 }", "", "2F00:09 zero reference", ["no such object"]),
        ("", HOMED, "", "zero reference", []),
        ("", "voltage = { index = 0x2300 }", "", "2300:01 voltage", ["no such object"]),
        ("", 'voltage = { kind = "dc_link" }', "", "voltage", ["DC link"]),
        ("", "", "[limits]\njoint_min = 0.0", "joint angle", ["-0.32"]),
        ("fault_at_power_on = 0x3220", "", "", "state", ["0x3220: DC link under-voltage", "remove its cause"]),
        (
            'values = { "60AA" = 0x00C00300 }',
            'units = { acceleration = "counts/s^2" }',
            "",
            "1 rad/s^2 of the joint",
            ["200.535 by the drive", "27379.7 by units.acceleration"],
        ),
    ],
)
def test_problem_is_named_and_the_command_fails(
    habits: str, keys: str, sections: str, what: str, texts: list[str], check: Check
) -> None:
    code, findings = check(habits, keys, sections=sections)
    assert code == 1
    problem = found([f for f in findings if f["verdict"] == "problem"], what)
    assert all(text in problem["found"] for text in texts), problem


def test_texts_in_the_table_are_whole(daq_in_process: Runner, tmp_path: Path) -> None:
    emcy = 'emcy = { "FF01" = "[[brake]] of the door" }'
    (tmp_path / "rig.toml").write_text(f'name = "bench"\n{DRIVES}'.replace("node_id", f"{emcy}\nnode_id"))
    (tmp_path / "sim.toml").write_text("[[drives]]\nhabits = { fault_at_power_on = 0xFF01 }\n")
    done = daq_in_process("check", "--rig", "rig.toml", "--sim", "sim.toml")
    assert "[[brake]]" in done.out
    assert "…" not in done.out


def test_missing_drives_are_named(daq_in_process: Runner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(SdoClient, "RESPONSE_TIMEOUT", 0.1)  # nobody is there to be waited for
    (tmp_path / "rig.toml").write_text(f'name = "bench"\n{udp_bus()}{DRIVES}')
    done = daq_in_process("check", "--rig", "rig.toml")
    assert done.code == 1
    assert "no answer from joint 1 (node 1), joint 2 (node 2), joint 3 (node 3)" in done.err


@pytest.mark.parametrize(
    ("habits", "keys", "what", "field", "text"),
    [
        ("", "", "mode that is set", "found", "0"),
        ("", "", "supply", "found", "48 V"),
        ("", "", "1 rad/s^2 of the joint", "found", "27379.7 counts/s^2 (60AAh)"),
        ("", "", "6085:00", "expected", "4106961 = 150 rad/s^2"),
        # 150 rad/s^2 times 21 * 60 / (2 pi) rpm/s; the drive has 1,000,000.
        ('values = { "60AA" = 0x00C00300 }', "", "6085:00", "expected", "30080 = 150 rad/s^2"),
        ('values = { "60AA" = 0x00C00300 }', "", "6085:00", "found", "1000000 = 4987 rad/s^2"),
        ('values = { "60A9" = 0x00123456 }', "", "unit of velocity", "found", "0x00123456 is unknown"),
        (
            "referenced_mask = 0x8000",
            "homed = { index = 0x6041, mask = 0x8000 }",
            "zero reference",
            "verdict",
            "fine",
        ),
    ],
)
def test_what_the_drive_says_is_shown_in_units_of_the_joint(
    habits: str, keys: str, what: str, field: str, text: str, check: Check
) -> None:
    code, findings = check(habits, keys)
    assert code == 0
    assert text in found(findings, what)[field]


def test_refused_value_is_known_when_it_is_written(check: Check) -> None:
    habits = 'allowed = { "605A" = [6] }, values = { "605A" = 6 }'
    assert check(habits)[0] == 0
    code, findings = check(habits, "", "--set-up")
    assert code == 1
    assert "quick_stop_option" in findings[-1]["found"]
    code, findings = check(habits, "quick_stop_option = 6", "--set-up")
    assert code == 0
    assert {f["verdict"] for f in findings if f["what"].startswith(("6085:00", "1A00:01"))} == {"fine"}
    assert findings[-1]["found"] == "written and read back"


def test_protections_are_listed_with_what_protects(check: Check, tmp_path: Path) -> None:
    code, findings = check('refuse_write = ["6066"]', 'accept_missing = ["6066"]')
    assert code == 0
    names = ("watchdog", "following error", "position limits", "quick stop ramp")
    shown = [(f["found"], f["verdict"]) for name in names for f in [found(findings, name)]]
    assert shown == [(f"by {by}", "noted") for by in ("1016h, 6007h", "6065h, 6066h", "607Dh", "605Ah, 605Eh, 6085h")]
