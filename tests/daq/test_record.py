"""`daq record` as a user runs it, on the simulated rig."""

import json
import re
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest

from recordings.drives import Drive
from recordings.reader import read, read_can
from recordings.recording import Recording
from tests import timekeeping
from tests.conftest import Finished, Runner, launcher
from tests.running import free_port, last_told, wait_until_moving
from tests.timekeeping import Machine

RIG = """
name = "bench"
[[drives]]
node_id = 1
[[drives]]
node_id = 2
[[drives]]
node_id = 3
"""


ONE_CYCLE = ("--traj", "fig5a", "--cycles", 1, "--rate", 250)
PATIENT = "[limits]\nsilence = 0.3\nhost_stall = 0.3\nfollowing_error = 0.3\ntorque = 500.0\n"
"""Wide limits for real time on a busy computer, whose stalls make the motion jerky."""


def test_every_sync_is_answered_and_the_same_seed_gives_the_same_bytes(daq: Runner, tmp_path: Path) -> None:
    for seed, out in ((0, "a.mcap"), (0, "b.mcap"), (1, "other.mcap")):
        done = daq("record", *ONE_CYCLE, "--seed", seed, "--out", out, "--json")
        assert done.code == 0, done.err
        assert "SIMULATED RIG" in done.err
    figures = json.loads(done.out)
    assert (figures["answers_lost"], figures["cycles_missed"], figures["simulated"]) == (0, 0, True)
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()

    recording = read(tmp_path / "a.mcap")
    assert recording.complete
    assert recording.run.simulated
    assert recording.run.exit_status == 0
    assert len(recording.time) == figures["cycles"]
    np.testing.assert_allclose(np.diff(recording.time), 1 / 250, rtol=1e-9)
    assert not np.isnan(recording.position).any()
    assert not np.isnan(recording.voltage).any()
    assert (recording.repeat == 0).sum() == 1000

    other = read(tmp_path / "other.mcap")
    np.testing.assert_array_equal(other.command, recording.command)
    assert 0.005 < np.std(other.voltage - recording.voltage) < 0.05, "only the noise differs"
    moving = np.flatnonzero(recording.repeat == 0)
    assert np.abs(recording.position[moving + 1] - recording.command[moving]).max() < 0.01, "one cycle later"

    frames = read_can(tmp_path / "a.mcap")
    syncs = (frames.id == 0x80).sum()
    assert syncs == figures["cycles"]
    for node in (1, 2, 3):
        assert ((frames.id == 0x180 + node) & ~frames.sent).sum() == syncs


def test_hidden_effects_are_sealed_and_leave_no_name_in_the_recording(daq: Runner, tmp_path: Path) -> None:
    from drivers.simulated.effect import discover
    from drivers.simulated.seal import unseal

    done = daq("record", *ONE_CYCLE, "--hidden", 7, "--out", "blind.mcap")
    assert done.code == 0, done.err
    truth = unseal(tmp_path / "blind.sealed.json")
    assert truth["seed"] == 7
    (effect,) = truth["effects"]
    recording = read(tmp_path / "blind.mcap")
    output = done.out + done.err + recording.run.model_dump_json() + "".join(e.message for e in recording.events)
    raw = (tmp_path / "blind.mcap").read_bytes() + (tmp_path / "blind.sealed.json").read_bytes()
    for name in set(discover()) - set(Drive.model_fields):  # each rig has the latter
        assert name not in output
        assert name.encode() not in raw
    assert 0.004 < effect["size"] < 0.11


BAD = {
    "unknown trajectory": (["--traj", "fig9"], "unknown trajectory 'fig9'"),
    "unreachable path": (["--traj", "far.csv"], "limb"),
    "speed over limit": (["--traj", "fig5a", "--rig", "slow.toml"], "speed"),
    "missing rig file": (["--traj", "fig5a", "--rig", "none.toml"], "none.toml does not exist"),
    "rate too high for the bus": (["--traj", "fig5a", "--rate", "1250"], "choose --rate"),
    "rate the drives cannot be told": (["--traj", "fig5a", "--rate", "333"], "choose a rate such as"),
    "output exists": (["--traj", "fig5a", "--out", "there.mcap"], "exists and recordings are never overwritten"),
    "no such folder": (["--traj", "fig5a", "--out", "no/such/folder.mcap"], "does not exist"),
    "sim file with an unknown effect": (["--traj", "fig5a", "--sim", "effect.toml"], "magic"),
    "interface that is not there": (["--traj", "fig5a", "--rig", "nocan.toml"], "cannot be opened"),
    "hidden effect with a real rig": (["--traj", "fig5a", "--rig", "nocan.toml", "--hidden", "1"], "daq sim"),
    "hidden effect in a dry run": (["--traj", "fig5a", "--dry-run", "--hidden", "1"], "drop --hidden"),
    "DCF that is not there": (["--traj", "fig5a", "--rig", "dcf.toml"], "none.dcf"),
    "no trajectory at all": ([], "--traj"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_rejected_and_leaves_no_file(name: str, daq_in_process: Runner, tmp_path: Path) -> None:
    (tmp_path / "far.csv").write_text("time,x,y,z\n" + "".join(f"{k / 10},2.0,0,-0.7\n" for k in range(50)))
    (tmp_path / "slow.toml").write_text(RIG + "[limits]\nspeed = 0.5\n")
    (tmp_path / "effect.toml").write_text('[[effects]]\nname = "magic"\n')
    (tmp_path / "nocan.toml").write_text(RIG + '[bus]\ninterface = "socketcan"\nchannel = "nocan7"\n')
    (tmp_path / "dcf.toml").write_text(RIG.replace("node_id = 3", 'node_id = 3\ndcf = "none.dcf"'))
    (tmp_path / "there.mcap").write_bytes(b"precious")
    files_before = sorted(tmp_path.iterdir())
    arguments, expected = BAD[name]
    done = daq_in_process("record", *arguments)
    assert done.code == 2
    assert expected in done.err
    assert sorted(tmp_path.iterdir()) == files_before
    assert (tmp_path / "there.mcap").read_bytes() == b"precious"


def test_disk_that_fills_up_ends_the_run_orderly(tmp_path: Path) -> None:
    """With a file limit of 300 kB, as on a full disk, the motion ramps down and the drives are disabled."""
    limited = (
        "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        f"resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000)); {launcher('daq')[-1]}"
    )
    command = [*launcher("daq")[:-1], limited, "record", "--traj", "fig5a", "--cycles", "1"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=600)
    assert done.returncode == 2, done.stderr
    assert "fig5a.mcap" in done.stderr
    assert "is whole" not in done.stderr
    assert "Traceback" not in done.stderr
    recording = read(tmp_path / "fig5a.mcap")
    assert not recording.complete
    assert len(recording.time) > 500


VARIANTS = {
    "interpolated position and torque actual": 'mode = "interpolated"\ntorque_actual = true',
    "polled voltage": 'voltage = { transfer = "sdo" }',
    "polled voltage beside torque actual": 'torque_actual = true\nvoltage = { transfer = "sdo" }',
    "counting backwards": "sign = -1\nzero_offset = 0.1\ncounts_per_turn = 4096",
}


@pytest.mark.slow
@pytest.mark.parametrize("name", VARIANTS)
def test_other_drive_types_are_recorded(name: str, daq: Runner, tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text(re.sub(r"(node_id = \d)", rf"\1\n{VARIANTS[name]}", RIG))
    for out in ("a.mcap", "b.mcap"):
        done = daq("record", "--traj", "fig5a", "--cycles", 1, "--rate", 200, "--rig", "rig.toml", "--out", out)
        assert done.code == 0, done.err
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()
    recording = read(tmp_path / "a.mcap")
    moving = np.flatnonzero(recording.repeat == 0)
    assert np.abs(recording.position[moving + 1] - recording.command[moving]).max() < 0.03
    torque = np.sign(recording.voltage) * recording.voltage**2
    if "torque_actual" in VARIANTS[name]:
        assert recording.effort is not None
        fresh = ~np.isnan(torque[moving])
        assert np.corrcoef(recording.effort[moving][fresh], torque[moving][fresh])[0, 1] > 0.99
    if "sdo" in VARIANTS[name]:
        np.testing.assert_allclose((~np.isnan(torque[moving])).mean(axis=0), 1 / 3, atol=0.01)


def test_dry_run_does_everything_except_power_and_file(daq: Runner, tmp_path: Path) -> None:
    done = daq("record", "--traj", "fig5a", "--cycles", "1", "--dry-run", "--json")
    assert done.code == 0, done.err
    assert done.err.splitlines()[-1] == "next: daq record --traj fig5a --cycles 1"
    figures = json.loads(done.out)
    assert figures["dry_run"]
    assert figures["cycles"] == 501
    assert figures["joint_position"] == pytest.approx([-0.3256] * 3, abs=1e-3)
    assert list(tmp_path.iterdir()) == []


def stopped(folder: Path, number: int, *arguments: str) -> tuple[bool, str]:
    """Send a signal to a run during the motion; return whether it got that far, and its output."""
    command = [*launcher("daq"), "record", "--traj", "fig5a", "--status", *arguments]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    process = subprocess.Popen(command, cwd=folder, text=True, **pipes)
    moved = wait_until_moving(process)
    process.send_signal(number)
    _, err = process.communicate(timeout=120)
    assert process.returncode == 1, err
    assert "Traceback" not in err
    assert ".mcap is whole" in err
    return moved, err


def _assert_ramped_down(recording: Recording) -> None:
    """Assert that no step of the command exceeds the steps of the motion itself."""
    assert recording.complete
    assert recording.run.exit_status == 1
    command_speed = np.abs(np.diff(recording.command, axis=0)) * recording.run.rate
    assert np.nanmax(command_speed) < 5.0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signal_during_the_motion_ends_in_disabled_drives_and_a_complete_file(number: int, tmp_path: Path) -> None:
    moved, err = stopped(tmp_path, number, "--cycles", "150")
    assert moved
    assert f"stopped by the operator ({signal.Signals(number).name})" in err
    recording = read(tmp_path / "fig5a.mcap")
    _assert_ramped_down(recording)
    assert recording.repeat.max() < 149
    assert all(word & 0x6F == 0x40 for word in recording.statusword[-1])


@pytest.mark.realtime
def test_signal_in_real_time_ends_in_disabled_drives_and_a_complete_file(tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text(RIG + PATIENT)
    with timekeeping.watched() as machine:
        arguments = ["--cycles", "20", "--pace", "realtime", "--rig", "rig.toml"]
        moved, err = stopped(tmp_path, signal.SIGINT, *arguments)
    recording = read(tmp_path / "fig5a.mcap")
    _assert_ramped_down(recording)
    # If the host stalls, the run may have ended before the signal, or lack the last answers.
    machine.expect(moved and "stopped by the operator (SIGINT)" in err, err)
    machine.expect("NOT CONFIRMED" not in err, err)
    assert all(word & 0x6F == 0x40 for word in recording.statusword[-1])


@pytest.mark.realtime
def test_twenty_seconds_in_real_time_account_for_every_frame(daq: Runner, tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text(RIG + PATIENT)
    with timekeeping.watched() as machine:
        done = daq("record", "--traj", "fig5a", "--pace", "realtime", "--rig", "rig.toml", "--status")
    _assert_accounted_for(tmp_path / "fig5a.mcap", done, machine)


@pytest.mark.realtime
def test_twenty_seconds_between_two_processes_account_for_every_frame(daq: Runner, tmp_path: Path) -> None:
    bus = f'[bus]\ninterface = "udp_multicast"\nchannel = "239.74.163.2"\nport = {free_port()}\n'
    (tmp_path / "udp.toml").write_text(RIG + bus + PATIENT)
    simulation = subprocess.Popen(
        [*launcher("daq"), "sim", "--rig", "udp.toml"], cwd=tmp_path, stdout=subprocess.PIPE, text=True
    )
    try:
        assert simulation.stdout is not None
        assert "simulated drives (nodes 1, 2, 3)" in simulation.stdout.readline()
        with timekeeping.watched() as machine:
            done = daq("record", "--traj", "fig5a", "--rig", "udp.toml", "--status")
    finally:
        simulation.send_signal(signal.SIGTERM)
        assert simulation.wait(timeout=120) == 0
        simulation.stdout.close()
    _assert_accounted_for(tmp_path / "fig5a.mcap", done, machine)


def _assert_accounted_for(path: Path, done: Finished, machine: Machine) -> None:
    """Assert that the file accounts for every cycle, even if a slow computer ended the run early."""
    assert done.code in (0, 1), done.err
    machine.expect(path.exists(), done.err)  # a drive that answers too late is not found
    recording, frames, figures = read(path), read_can(path), last_told(done.out.splitlines())
    assert recording.run.exit_status == done.code
    assert len(recording.time) == figures["cycles"] + figures["cycles_missed"]
    assert recording.gaps.sum() == figures["answers_lost"] + 3 * figures["cycles_missed"]
    assert (frames.id == 0x80).sum() == figures["cycles"]
    answers = sum(int((frames.id == 0x180 + node).sum()) for node in (1, 2, 3))
    # An answer that came after its cycle is in /can, but is a gap in the samples.
    assert 3 * figures["cycles"] - figures["answers_lost"] <= answers <= 3 * figures["cycles"]
    machine.expect(done.code == 0, done.err)
    lost = figures["answers_lost"] / (3 * figures["cycles"])
    machine.expect(lost < 0.2, f"{100 * lost:.0f} % of the answers came too late")
