"""`daq record` over serial lines as a user runs it, on simulated drives behind pseudo-terminals."""

import json
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from recordings.reader import read, read_can
from tests import timekeeping
from tests.conftest import Runner, launcher
from tests.running import last_told

DRIVES = "".join(f"[[drives]]\nnode_id = {i}\n" for i in (1, 2, 3))


def write_rig(path: Path, rate: float, ports: list[str], more: str = "") -> None:
    bus = f'[bus]\ntransport = "serial"\nports = {json.dumps(ports)}\n'
    path.write_text(f'name = "serial bench"\nrate = {rate}\n{bus}{more}{DRIVES}')


@pytest.mark.parametrize(
    ("rate", "ports", "load"),
    [
        (30.0, ["simulated"], "24.0 ms on the wire, 72% of the period"),
        (80.0, ["simulated1", "simulated2", "simulated3"], ""),
    ],
)
def test_lockstep_is_complete_and_the_same_seed_gives_the_same_bytes(
    rate: float, ports: list[str], load: str, daq: Runner, tmp_path: Path
) -> None:
    """The order in which three lines are served must not affect the recording."""
    write_rig(tmp_path / "rig.toml", rate, ports)
    for out in ("a.mcap", "b.mcap"):
        done = daq("record", "--traj", "fig5a", "--cycles", 1, "--rig", "rig.toml", "--out", out, "--json")
        assert done.code == 0, done.err
    assert "SIMULATED RIG" in done.err
    assert f"a cycle takes up to {load}" in done.err
    figures = json.loads(done.out)
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
    refused = daq_in_process("sim", "--rig", "one.toml")
    assert (refused.code, "bus.ports to names in the file system" in refused.err) == (2, True)
    done = daq_in_process("check", "--rig", "one.toml", "--json")
    assert done.code == 0, done.err
    findings = {finding["what"]: finding for finding in json.loads(done.out)["findings"]}
    assert findings["r0xba: following error limit [counts]"]["verdict"] == "will be written"
    assert findings["state"]["found"] == "off"


BAD = {
    "rate too high for the line": (["--rig", "one.toml", "--rate", "50"], "choose --rate 31 or less"),
    "port that is not there": (["--rig", "gone.toml"], "serial port '/dev/no/such/port' cannot be opened"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_rejected_and_leaves_no_file(name: str, daq_in_process: Runner, tmp_path: Path) -> None:
    write_rig(tmp_path / "one.toml", 30.0, ["simulated"])
    write_rig(tmp_path / "gone.toml", 30.0, ["/dev/no/such/port"])
    before = sorted(tmp_path.iterdir())
    arguments, expected = BAD[name]
    done = daq_in_process("record", "--traj", "fig5a", *arguments)
    assert done.code == 2
    assert expected in done.err
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.slow
def test_one_slow_line_is_fitted_within_what_its_rate_permits(daq: Runner, ident: Runner, tmp_path: Path) -> None:
    write_rig(tmp_path / "one.toml", 31.0, ["simulated"])
    assert daq("record", "--traj", "fig5a", "--rig", "one.toml", "--out", "run.mcap").code == 0
    done = ident("fit", "run.mcap", "--iterations", 300, "--without", "rod_inertia", "--details")
    assert done.code == 0, done.err
    assert "Low-pass: 6.2 Hz" in done.out
    mass, gravity, *inertias = parameters(tmp_path / "run.model.json")[:5]
    assert mass == pytest.approx(2.75, rel=0.05)
    assert gravity == pytest.approx(6.6, rel=0.05)
    assert inertias == pytest.approx([0.23] * 3, rel=0.1)


def parameters(model: Path) -> list[float]:
    return [parameter["value"] for parameter in json.loads(model.read_text())["parameters"]]


@contextmanager
def served(folder: Path, rig: str, pace: str) -> Iterator[None]:
    """Run `daq sim` in a separate process."""
    command = [*launcher("daq"), "sim", "--rig", rig, "--pace", pace]
    simulation = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True)
    try:
        assert simulation.stdout is not None
        assert "simulated drives (nodes 1, 2, 3) on" in simulation.stdout.readline()
        yield
    finally:
        simulation.send_signal(signal.SIGTERM)
        assert simulation.wait(timeout=120) == 0
        simulation.stdout.close()


@pytest.mark.slow
def test_two_programs_on_pseudo_terminals(daq: Runner, ident: Runner, tmp_path: Path) -> None:
    ports = [str(tmp_path / f"line{i}") for i in (1, 2, 3)]
    write_rig(tmp_path / "lines.toml", 100.0, ports, "baud = 460800\n")
    with served(tmp_path, "lines.toml", "lockstep"):
        done = daq("record", "--traj", "fig5a", "--rig", "lines.toml", "--pace", "lockstep", "--json")
        assert done.code == 0, done.err
    assert not any(Path(port).is_symlink() for port in ports)
    assert json.loads(done.out)["answers_lost"] == 0
    done = ident("fit", "fig5a.mcap", "--iterations", 300, "--without", "rod_inertia")
    assert done.code == 0, done.err
    mass, gravity, *inertias = parameters(tmp_path / "fig5a.model.json")[:5]
    assert (mass, gravity) == pytest.approx((2.75, 6.6), rel=0.03)
    assert inertias == pytest.approx([0.23] * 3, rel=0.03)


@pytest.mark.realtime
def test_two_programs_in_real_time_account_for_every_answer(daq: Runner, tmp_path: Path) -> None:
    # A quarter of the rate that these lines permit, and long timeouts: the test computer may be busy.
    patience = "[limits]\nsilence = 0.5\nhost_stall = 0.5\nfollowing_error = 0.3\ntorque = 200.0\n"
    ports = [str(tmp_path / f"line{i}") for i in (1, 2, 3)]
    write_rig(tmp_path / "lines.toml", 50.0, ports, f"baud = 460800\nreply_timeout = 0.1\n{patience}")
    with timekeeping.watched() as machine, served(tmp_path, "lines.toml", "realtime"):
        done = daq("record", "--traj", "fig5a", "--cycles", 2, "--rig", "lines.toml", "--status")
    assert done.code in (0, 1), done.err
    machine.expect((tmp_path / "fig5a.mcap").exists(), done.err)
    figures, recording = last_told(done.out.splitlines()), read(tmp_path / "fig5a.mcap")
    assert len(recording.time) == figures["cycles"] + figures["cycles_missed"]
    assert recording.gaps.sum() == figures["answers_lost"] + 3 * figures["cycles_missed"]
    delay = [recording.extra[f"position_delay_{joint}"] for joint in (1, 2, 3)]
    np.testing.assert_array_equal(np.isnan(recording.position), np.isnan(np.column_stack(delay)))
    machine.expect(done.code == 0, done.err)
    machine.expect(all(0 < np.nanmedian(late) < 0.02 for late in delay), "answers come late")
