"""`daq record` as a user runs it, on the simulated rig."""

import re
import shlex
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest

from recordings.drives import Drive
from recordings.reader import read, read_can
from recordings.recording import Recording
from tests import timekeeping
from tests.conftest import Runner, launcher
from tests.failures import assert_safe
from tests.patience import patient
from tests.running import DRIVES, accounted_for, last_told, served, udp_bus, wait_until_moving

RIG = f'name = "bench"\n{DRIVES}'
ONE_CYCLE = ("--traj", "fig5a", "--cycles", 1, "--rate", 250)
PATIENT = "[limits]\nsilence = 0.3\nhost_stall = 0.3\nfollowing_error = 0.3\ntorque = 500.0\n"
"""Wide limits for real time on a busy computer, whose stalls make the motion jerky."""


def test_every_sync_is_answered_and_the_same_seed_gives_the_same_bytes(
    daq_in_process: Runner, tmp_path: Path
) -> None:
    for seed, out in ((0, "a.mcap"), (0, "b.mcap"), (1, "other.mcap")):
        done = daq_in_process("record", *ONE_CYCLE, "--seed", seed, "--out", out, "--json")
        figures = done.figures
        assert "SIMULATED RIG" in done.err
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


def test_a_run_without_torque_leads_to_its_figures(daq_in_process: Runner, tmp_path: Path) -> None:
    (tmp_path / "blind.toml").write_text(RIG.replace("node_id", 'torque_source = "none"\nnode_id'))
    points = "".join(f"{k / 5},{0.1 * (k % 2)},0,0\n" for k in range(11))
    (tmp_path / "way.csv").write_text(f"time,joint_1,joint_2,joint_3\n{points}")
    done = daq_in_process("record", "--traj", "way.csv", "--cycles", 1, "--rate", 100, "--rig", "blind.toml")
    assert done.code == 0, done.err
    assert "next: daq info way.csv.mcap" in done.err


def test_recordings_without_a_name_are_numbered_and_the_next_command_can_be_pasted(
    daq_in_process: Runner, tmp_path: Path
) -> None:
    (tmp_path / "fig5a.mcap").write_text("mine")
    done = daq_in_process("record", *ONE_CYCLE)
    assert (done.code, (tmp_path / "fig5a.mcap").read_text()) == (0, "mine"), done.err
    assert done.err.splitlines()[-1] == "next: ident fit fig5a-2.mcap"
    name = f"my {'long ' * 20}name.mcap"
    done = daq_in_process("record", *ONE_CYCLE, "--out", name)
    assert shlex.split(done.err.splitlines()[-1]) == ["next:", "ident", "fit", name]


def test_hidden_effects_are_sealed_and_leave_no_name_in_the_recording(daq_in_process: Runner, tmp_path: Path) -> None:
    from drivers.simulated.effect import discover
    from drivers.simulated.seal import unseal

    done = daq_in_process("record", *ONE_CYCLE, "--hidden", 7, "--out", "blind.mcap")
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


def test_disk_that_fills_up_ends_the_run_orderly(tmp_path: Path) -> None:
    """With a file limit of 300 kB, as on a full disk, the motion ramps down and the drives are disabled."""
    limited = (
        "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        f"resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000)); {launcher('daq')[-1]}"
    )
    command = [*launcher("daq")[:-1], limited, "record", "--traj", "fig5a", "--cycles", "1"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=patient(600))
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
    figures = done.figures
    assert done.err.splitlines()[-1] == "next: daq record --traj fig5a --cycles 1"
    assert (figures["dry_run"], figures["cycles"]) == (True, 501)
    assert figures["joint_position"] == pytest.approx([-0.3256] * 3, abs=1e-3)
    assert list(tmp_path.iterdir()) == []


def stopped(folder: Path, number: int, *arguments: str) -> tuple[bool, str]:
    """Send a signal to a run during the motion; return whether it got that far, and its output."""
    command = [*launcher("daq"), "record", "--traj", "fig5a", "--status", *arguments]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    process = subprocess.Popen(command, cwd=folder, text=True, **pipes)
    moved = wait_until_moving(process)
    process.send_signal(number)
    _, err = process.communicate(timeout=patient(120))
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
    assert_safe(all(word & 0x6F == 0x40 for word in recording.statusword[-1]), recording.statusword[-1])


@pytest.mark.realtime
def test_a_run_between_two_processes_accounts_for_every_frame(daq: Runner, tmp_path: Path) -> None:
    (tmp_path / "udp.toml").write_text(RIG + udp_bus() + PATIENT)
    with served(tmp_path, "--rig", "udp.toml"), timekeeping.watched() as machine:
        done = daq("record", "--traj", "fig5a", "--cycles", 2, "--rig", "udp.toml", "--status")
    # The file accounts for every cycle, even if a slow computer ended the run early.
    assert done.code in (0, 1), done.err
    file, figures = tmp_path / "fig5a.mcap", last_told(done.out.splitlines())
    machine.expect(file.exists(), done.err)  # a drive that answers too late is not found
    recording, frames = accounted_for(file, figures)
    assert recording.run.exit_status == done.code
    assert (frames.id == 0x80).sum() == figures["cycles"]
    answers = np.isin(frames.id, (0x181, 0x182, 0x183)).sum()
    # An answer that came after its cycle is in /can, but is a gap in the samples.
    assert 3 * figures["cycles"] - figures["answers_lost"] <= answers <= 3 * figures["cycles"]
    machine.expect(done.code == 0, done.err)
    lost = figures["answers_lost"] / (3 * figures["cycles"])
    machine.expect(lost < 0.2, f"{100 * lost:.0f} % of the answers came too late")
