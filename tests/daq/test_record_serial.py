"""`daq record` over serial lines as a user runs it, on simulated drives behind pseudo-terminals."""

import json
from pathlib import Path

import numpy as np
import pytest

from recordings.reader import read, read_can
from tests import timekeeping
from tests.conftest import Runner
from tests.running import DRIVES, accounted_for, last_told, served

WATCHDOG = 'registers = { watchdog = "r0xf0" }\n'


def write_rig(path: Path, rate: float, ports: list[str], more: str = "", registers: str = WATCHDOG) -> None:
    bus = f'[bus]\ntransport = "serial"\nports = {json.dumps(ports)}\n{registers}'
    path.write_text(f'name = "serial bench"\nrate = {rate}\n{bus}{more}{DRIVES}')


@pytest.mark.parametrize(
    ("rate", "ports", "load"),
    [
        (30.0, ["simulated"], "24.0 ms on the wire, 72% of the period"),
        pytest.param(80.0, ["simulated1", "simulated2", "simulated3"], "", marks=pytest.mark.slow),
    ],
)
def test_lockstep_is_complete_and_the_same_seed_gives_the_same_bytes(
    rate: float, ports: list[str], load: str, daq: Runner, tmp_path: Path
) -> None:
    """The order in which three lines are served must not affect the recording."""
    write_rig(tmp_path / "rig.toml", rate, ports)
    for out in ("a.mcap", "b.mcap"):
        done = daq("record", "--traj", "fig5a", "--cycles", 1, "--rig", "rig.toml", "--out", out, "--json")
        figures = done.figures
    assert "SIMULATED RIG" in done.err
    assert f"a cycle takes up to {load}" in done.err
    assert (figures["answers_lost"], figures["frames_sent"], figures["simulated"]) == (0, 0, True)
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()
    recording = read(tmp_path / "a.mcap")
    assert recording.run.exit_status == 0
    assert not np.isnan([recording.position, recording.voltage]).any()
    assert (recording.repeat == 0).sum() == 4 * rate
    assert len(read_can(tmp_path / "a.mcap").id) == 0
    # Off, on during the motion, off again: the statuswords of a CiA 402 drive.
    assert {int(word) for word in recording.statusword[recording.repeat == 0].ravel()} == {0x27}
    assert {int(word) for word in recording.statusword[-1]} == {0x40}


def test_check_compares_the_drive_registers(daq_in_process: Runner, tmp_path: Path) -> None:
    write_rig(tmp_path / "one.toml", 30.0, ["simulated"])
    checked = daq_in_process("check", "--rig", "one.toml", "--json").figures
    findings = {finding["what"]: finding for finding in checked["findings"]}
    assert findings["r0xba: following error limit [counts]"]["verdict"] == "will be written"
    assert findings["state"]["found"] == "off"
    assert (findings["watchdog"]["found"], findings["watchdog"]["verdict"]) == ("by r0xf0", "noted")
    assert findings["absolute zero"]["found"].startswith("-0.3256 rad; ")
    assert "-0.3256 rad" in daq_in_process("check", "--rig", "one.toml").out.replace("\n", "")


def test_line_without_a_watchdog_is_driven_only_where_the_rig_file_accepts_it(
    daq_in_process: Runner, tmp_path: Path
) -> None:
    write_rig(tmp_path / "bare.toml", 30.0, ["simulated"], registers="")
    record = ("record", "--traj", "fig5a", "--cycles", 1, "--rig")
    for command in (record, ("jog", "--joint", 1, "--by", 0.02, "--rig"), ("record", "--dry-run", *record[1:])):
        refused = daq_in_process(*command, "bare.toml")
        assert refused.code == 2
        assert 'accept_missing = ["watchdog"]' in refused.err
    checked = daq_in_process("check", "--rig", "bare.toml", "--json")
    rows = [row["verdict"] for row in json.loads(checked.out)["findings"] if row["what"] == "watchdog"]
    assert (checked.code, rows) == (1, ["problem"] * 3)
    accepted = (tmp_path / "bare.toml").read_text().replace("[[drives]]", '[[drives]]\naccept_missing = ["watchdog"]')
    (tmp_path / "open.toml").write_text(accepted)
    assert daq_in_process("check", "--rig", "open.toml").code == 0
    done = daq_in_process(*record, "open.toml", "--out", "open.mcap")
    assert done.code == 0
    recording = read(tmp_path / "open.mcap")
    assert [drive.accept_missing for drive in recording.rig.drives] == [("watchdog",)] * 3
    told = [event.message for event in recording.events if "watchdog" in event.message]
    assert len(told) == 1
    assert "the rig file accepts it" in told[0]


@pytest.mark.slow
def test_two_programs_on_pseudo_terminals(daq: Runner, ident: Runner, tmp_path: Path) -> None:
    ports = [str(tmp_path / f"line{i}") for i in (1, 2, 3)]
    write_rig(tmp_path / "lines.toml", 100.0, ports, "baud = 460800\n")
    with served(tmp_path, "--rig", "lines.toml", "--pace", "lockstep"):
        done = daq("record", "--traj", "fig5a", "--rig", "lines.toml", "--pace", "lockstep", "--json")
    assert not any(Path(port).is_symlink() for port in ports)
    assert done.figures["answers_lost"] == 0
    model = ident("fit", "fig5a.mcap", "--set", "iterations=300", "--without", "rod_inertia", "--json").figures
    mass, gravity, *inertias = [parameter["value"] for parameter in model["parameters"][:5]]
    assert (mass, gravity) == pytest.approx((2.75, 6.6), rel=0.03)
    assert inertias == pytest.approx([0.23] * 3, rel=0.03)


@pytest.mark.realtime
def test_two_programs_in_real_time_account_for_every_answer(daq: Runner, tmp_path: Path) -> None:
    # A quarter of the rate that these lines permit, and long timeouts: the test computer may be busy.
    patience = "[limits]\nsilence = 0.5\nhost_stall = 0.5\nfollowing_error = 0.3\ntorque = 200.0\n"
    ports = [str(tmp_path / f"line{i}") for i in (1, 2, 3)]
    write_rig(
        tmp_path / "lines.toml",
        50.0,
        ports,
        f"baud = 460800\nreply_timeout = 0.1\nwatchdog_timeout = 1.0\n{patience}",
    )
    with timekeeping.watched() as machine, served(tmp_path, "--rig", "lines.toml"):
        done = daq("record", "--traj", "fig5a", "--cycles", 1, "--rig", "lines.toml", "--status")
    assert done.code in (0, 1), done.err
    machine.expect((tmp_path / "fig5a.mcap").exists(), done.err)
    recording, _ = accounted_for(tmp_path / "fig5a.mcap", last_told(done.out.splitlines()))
    delay = [recording.extra[f"position_delay_{joint}"] for joint in (1, 2, 3)]
    np.testing.assert_array_equal(np.isnan(recording.position), np.isnan(np.column_stack(delay)))
    machine.expect(done.code == 0, done.err)
    machine.expect(all(0 < np.nanmedian(late) < 0.02 for late in delay), "answers come late")
