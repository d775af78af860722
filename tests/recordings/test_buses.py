"""Section [bus] of the rig file: transports, defaults and refused values."""

from pathlib import Path

import pytest

from recordings.buses import CanBus, SerialBus
from recordings.errors import BadInput
from recordings.rig import Rig, load_rig

DRIVES = 'name = "r"\n' + "".join(f"[[drives]]\nnode_id = {i}\n" for i in (1, 2, 3))


def load(folder: Path, section: str) -> Rig:
    path = folder / "rig.toml"
    path.write_text(f"{DRIVES}[bus]\n{section}", encoding="utf-8")
    return load_rig(path)


def test_transport_is_chosen_and_survives_a_round_trip(tmp_path: Path) -> None:
    can = load(tmp_path, 'channel = "can7"\n')
    assert can.can == CanBus(channel="can7")
    serial = load(tmp_path, 'transport = "serial"\n')
    assert serial.serial == SerialBus()
    for rig in (can, serial):
        assert Rig.model_validate_json(rig.model_dump_json()) == rig
    with pytest.raises(BadInput, match=r"on a CAN bus expected, bus\.transport = 'serial' found"):
        _ = serial.can
    with pytest.raises(BadInput, match=r"on serial lines expected, bus\.transport = 'canopen' found"):
        _ = can.serial


def test_serial_registers_and_status_bits_are_configurable(tmp_path: Path) -> None:
    text = (
        'transport = "serial"\nsetup = { r0xc8 = 256 }\n[bus.registers]\nvoltage = "r0x1e"\n[bus.status]\noff = 1\n'
    )
    bus = load(tmp_path, text).serial
    assert (bus.registers.voltage, bus.status.off, bus.setup) == ("r0x1e", 1, {"r0xc8": 256})


@pytest.mark.parametrize(
    ("section", "reason"),
    [
        ('transport = "usb"\n', '\'bus\': a section with transport = "canopen" .* or "serial" expected'),
        ('interfase = "virtual"\n', "unknown key 'bus.interfase'"),
        ('transport = "serial"\nchannel = "can0"\n', "unknown key 'bus.channel'"),
        ('transport = "serial"\nbaud = 300\n', "'bus.baud': .*1200.*found 300"),
        ('transport = "serial"\nmax_load = 0.9\n', "'bus.max_load': .*0.8"),
        ('transport = "serial"\nports = []\n', "'bus.ports'"),
        ('transport = "serial"\nports = ["a", "b"]\n', "bus.ports: one line for all drives or 3 expected, 2 found"),
        ('transport = "serial"\nports = ["a", "a", "b"]\n', "every port once expected"),
        ('transport = "serial"\nprefixes = ["1 ", "2 "]\n', "bus.prefixes: none or 3 expected, 2 found"),
        ('transport = "serial"\nprefixes = ["1 ", "2 ", "1 "]\n', "prefixes of their own"),
    ],
)
def test_invalid_bus_section_is_explained(tmp_path: Path, section: str, reason: str) -> None:
    with pytest.raises(BadInput, match=reason):
        load(tmp_path, section)
