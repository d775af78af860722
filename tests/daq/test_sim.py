"""`daq sim` as a separate program: orderly end, and rejected starts."""

import signal
from pathlib import Path

import pytest

from tests.conftest import Runner
from tests.running import free_port, served

DRIVES = "".join(f"[[drives]]\nnode_id = {i}\n" for i in (1, 2, 3))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signal_ends_the_program_orderly(number: signal.Signals, tmp_path: Path) -> None:
    ports = [str(tmp_path / f"line{i}") for i in (1, 2, 3)]
    (tmp_path / "lines.toml").write_text(f'name = "b"\n[bus]\ntransport = "serial"\nports = {ports}\n{DRIVES}')
    with served(tmp_path, "--rig", "lines.toml") as process:
        assert Path(ports[0]).is_symlink()
        process.send_signal(number)
        _, error = process.communicate(timeout=120)
    assert error == "next: daq record --traj fig5a --rig lines.toml\n"
    assert not any(Path(port).is_symlink() for port in ports)


def test_second_simulation_with_the_same_node_ids_is_rejected(daq: Runner, tmp_path: Path) -> None:
    bus = f'[bus]\ninterface = "udp_multicast"\nchannel = "239.74.163.31"\nport = {free_port()}\n'
    (tmp_path / "bus.toml").write_text(f'name = "b"\n{bus}{DRIVES}')
    with served(tmp_path, "--rig", "bus.toml"):
        done = daq("sim", "--rig", "bus.toml", "--hidden", 1)
    assert done.code == 2
    assert "node 1 answers; end the other `daq sim`" in done.err
    assert not (tmp_path / "sim.sealed.json").exists()
