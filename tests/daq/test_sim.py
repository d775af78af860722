"""`daq sim` as a separate program: orderly end, and rejected starts."""

import signal
from pathlib import Path

import pytest

from tests import timekeeping
from tests.conftest import Runner
from tests.patience import patient
from tests.running import DRIVES, served, udp_bus


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signal_ends_the_program_orderly(number: signal.Signals, tmp_path: Path) -> None:
    ports = [str(tmp_path / f"line{i}") for i in (1, 2, 3)]
    (tmp_path / "lines.toml").write_text(f'name = "b"\n[bus]\ntransport = "serial"\nports = {ports}\n{DRIVES}')
    with served(tmp_path, "--rig", "lines.toml") as process:
        assert Path(ports[0]).is_symlink()
        process.send_signal(number)
        _, error = process.communicate(timeout=patient(120))
    assert (process.returncode, error) == (0, "next: daq record --traj fig5a --rig lines.toml\n")
    assert not any(Path(port).is_symlink() for port in ports)


@pytest.mark.realtime
def test_it_ends_with_the_program_that_started_it(tmp_path: Path) -> None:
    (tmp_path / "bus.toml").write_text(f'name = "b"\n{udp_bus()}{DRIVES}')
    with served(tmp_path, "--rig", "bus.toml") as process:
        assert process.stdin is not None
        process.stdin.close()  # as the system does when that program is killed
        assert process.wait(timeout=patient(120)) == 0


@pytest.mark.realtime
def test_second_simulation_with_the_same_node_ids_is_rejected(daq: Runner, tmp_path: Path) -> None:
    (tmp_path / "bus.toml").write_text(f'name = "b"\n{udp_bus()}{DRIVES}')
    with served(tmp_path, "--rig", "bus.toml"), timekeeping.watched() as machine:
        done = daq("sim", "--rig", "bus.toml", "--hidden", 1)
    machine.expect(done.code == 2, "the answer of node 1 came too late")
    assert "node 1 answers; end the other `daq sim`" in done.err
    assert not (tmp_path / "sim.sealed.json").exists()
