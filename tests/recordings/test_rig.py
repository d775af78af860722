"""Rig description with its buses, and the rig of imported measurements: defaults, refused values, the round trip."""

import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from recordings.buses import CanBus, SerialBus
from recordings.errors import BadInput
from recordings.imported import imported_rig, measured_torque
from recordings.rig import Drive, Rig, Torque, load_rig, simulated_rig

DRIVES = "".join(f"[[drives]]\nnode_id = {i}\n" for i in (1, 2, 3))

AXES = 'name = "r"\nmechanism = "axes"\n'
BUS = f'name = "r"\n{DRIVES}[bus]\n'
WRONG_FILES = [
    ('name = "r"\nspeed = 1\n' + DRIVES, "unknown key 'speed'"),
    (DRIVES, "key 'name' is missing"),
    ('name = "r"\nrate = "fast"\n' + DRIVES, "'rate': .*found 'fast'"),
    ('name = "r"\nrate = 0\n' + DRIVES, "'rate': .*greater than 0.*found 0"),
    ('name = "r"\n[limits]\nspeed = nan\n' + DRIVES, "'limits.speed'"),
    ('name = "r"\n' + DRIVES.replace("2", "1"), "node_id or axis, node 1 stands in two"),
    ('name = "r"\n' + DRIVES.replace("3", "128"), r"'drives\.2\.node_id': .*127.*found 128"),
    ('name = "r"\n[[drives]]\nnode_id = 1\n', "three .*drives.*, 1 found"),
    ('name = "r"\n' + DRIVES + "[torque]\ngain = [1.0, 2.0]\n", "torque.gain needs 3 numbers, 2 found"),
    ('name = "r"\n' + DRIVES + "[geometry]\nL2 = 0.4\n", "too short to close .*L2 = 0.4 m found"),
    ('name = "r"\n' + DRIVES + "[limits]\njoint_min = 2.0\n", "joint_min < joint_max expected, 2 and 1.4 found"),
    ('name = "r"\n' + DRIVES + "[limits]\nworkspace_z = [-0.4, -1.0]\n", r"\[lowest, highest\] expected"),
    ("name = ", "not valid TOML"),
    ('name = "r"\n', "one of .*drives.* for each of 3 joints expected, none found"),
    ('name = "r"\n[[axes]]\n' + DRIVES, 'axes belongs to the mechanism "axes", "delta" found'),
    (AXES, r'mechanism "axes" needs an \[\[axes\]\] section'),
    (AXES + "[[axes]]\n" + DRIVES, r"1 joints has as many \[\[drives\]\], 3 found"),
    (AXES + "[[axes]]\n[geometry]\nL2 = 0.9\n", 'geometry belongs to the mechanism "delta", "axes" found'),
    (AXES + '[[axes]]\ntype = "screw"\n', r"'axes\.0\.type'.*screw"),
    (AXES + "[[axes]]\n[torque]\ngain = [1.0, 2.0]\n", "torque.gain needs 1 numbers, 2 found"),
]
WRONG_KEYS = [
    ('units = { acceleration = "rpm" }', r"units.acceleration: counts/s\^2, rpm/s.*'rpm' found"),
    ('units = { acceleration = "0 rpm/s" }', "'0 rpm/s' found"),
    ('units = { acceleration = "nan rpm/s" }', "'nan rpm/s' found"),
    ('accept_missing = ["606"]', "one of watchdog, .* such as 6066 expected, '606' found"),
    ('accept_missing = ["watchdog"]', "accept_missing: indices of objects expected on this bus, watchdog found"),
    (
        'accept_missing = ["6066"]\n[bus]\ntransport = "serial"',
        "accept_missing: watchdog, .* expected on this bus, 6066 found",
    ),
    ("homed = { index = 0x6041, mask = 0x10000 }", "16-bit statusword.*0x10000 found"),
    ("quick_stop_option = 3", "quick_stop_option.*1, 2, 5 or 6"),
    ('watched = [{ index = 0x60B9 }]\n[bus]\ntransport = "serial"', "watched: .* on a CAN bus expected"),
    ('torque_source = "current_actual"', "one torque_source for all drives expected"),
]
"""Of the last drive."""
WRONG_BUSES = [
    ('transport = "usb"\n', '\'bus\': a section with transport = "canopen" .* or "serial" expected'),
    ('interfase = "virtual"\n', "unknown key 'bus.interfase'"),
    ('transport = "serial"\nchannel = "can0"\n', "unknown key 'bus.channel'"),
    ('transport = "serial"\nwatchdog_timeout = 0.0004\n', "'bus.watchdog_timeout': .*0.001.*found 0.0004"),
    ('transport = "serial"\nbaud = 300\n', "'bus.baud': .*1200.*found 300"),
    ('transport = "serial"\nmax_load = 0.9\n', "'bus.max_load': .*0.8"),
    ('transport = "serial"\nports = []\n', "'bus.ports'"),
    ('transport = "serial"\nregisters = { status = "" }\n', "'bus.registers.status'"),
    ('transport = "serial"\nports = ["a", "b"]\n', "bus.ports: one line for all drives or 3 expected, 2 found"),
    ('transport = "serial"\nports = ["a", "a", "b"]\n', "every port once expected"),
    ('transport = "serial"\nprefixes = ["1 ", "2 "]\n', "bus.prefixes: none or 3 expected, 2 found"),
    ('transport = "serial"\nprefixes = ["1 ", "2 ", "1 "]\n', "prefixes of their own"),
]


def load(folder: Path, text: str) -> Rig:
    path = folder / "rig.toml"
    path.write_text(text, encoding="utf-8")
    return load_rig(path)


def test_short_rig_file_gets_the_defaults(tmp_path: Path) -> None:
    text = 'name = "simulated delta robot"\n' + DRIVES
    rig = load(tmp_path, text)
    assert rig == simulated_rig()
    drive = load(tmp_path, text + 'accept_missing = ["605a"]\nunits = { acceleration = "1e-3 rpm/s" }').drives[2]
    assert (drive.accept_missing, drive.units.acceleration) == (("605A",), "1e-3 rpm/s")
    assert rig.dof == 3
    assert rig.joint_names == ("joint_1", "joint_2", "joint_3")
    assert (rig.geometry.L2, rig.geometry.L2_source) == (0.8, "assumed")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        *WRONG_FILES,
        *((f'name = "r"\n{DRIVES}{line}\n', reason) for line, reason in WRONG_KEYS),
        *((BUS + section, reason) for section, reason in WRONG_BUSES),
    ],
)
def test_invalid_rig_file_is_explained(tmp_path: Path, text: str, reason: str) -> None:
    with pytest.raises(BadInput, match=reason) as error:
        load(tmp_path, text)
    assert "rig.toml" in str(error.value)


@given(st.sampled_from([1, -1]), st.floats(-1, 1), st.floats(-2, 2))
def test_counts_and_joint_positions_convert_into_each_other(sign: int, zero: float, angle: float) -> None:
    drive = Drive(node_id=1, counts_per_turn=1000, gear=10.0, sign=sign, zero_offset=zero)
    assert drive.to_position(drive.to_counts(angle)) == pytest.approx(angle, abs=1e-12)
    assert drive.to_counts(zero + math.tau) == pytest.approx(sign * 10_000)


def test_axes_rig_loads_without_drives_unless_driven(tmp_path: Path) -> None:
    path = tmp_path / "rig.toml"
    path.write_text(AXES + '[torque]\nmap = "linear"\n[[axes]]\n[[axes]]\ntype = "prismatic"\n')
    rig = load_rig(path, driven=False)
    assert (rig.dof, rig.torque.gain) == (2, (1.0, 1.0))
    assert rig.position_units == ("rad", "m")
    assert rig.effort_units == ("N m", "N")
    assert Rig.model_validate_json(rig.model_dump_json()) == rig
    with pytest.raises(BadInput, match="for each of 2 joints expected, none found"):
        load_rig(path)


def test_current_as_torque_source_needs_its_scale(tmp_path: Path) -> None:
    text = AXES + '{}\n[[axes]]\n[[drives]]\nnode_id = 1\ntorque_source = "current_actual"\n{}\n'
    with pytest.raises(BadInput, match="needs rated_current"):
        load(tmp_path, text.format("", ""))
    with pytest.raises(BadInput, match=r"needs torque\.per_ampere"):
        load(tmp_path, text.format("", "rated_current = 4.2"))
    rig = load(tmp_path, text.format("torque = { per_ampere = [2.4] }", "rated_current = 4.2"))
    assert rig.drives[0].rated_current == 4.2


def test_transport_is_chosen_and_survives_a_round_trip(tmp_path: Path) -> None:
    can = load(tmp_path, BUS + 'channel = "can7"\n')
    assert can.can == CanBus(channel="can7")
    serial = load(tmp_path, BUS + 'transport = "serial"\n')
    assert serial.serial == SerialBus()
    for rig in (can, serial):
        assert Rig.model_validate_json(rig.model_dump_json()) == rig
    with pytest.raises(BadInput, match=r"on a CAN bus expected, bus\.transport = 'serial' found"):
        _ = serial.can
    with pytest.raises(BadInput, match=r"on serial lines expected, bus\.transport = 'canopen' found"):
        _ = can.serial


def test_three_joints_are_a_delta_robot_and_others_axes_unless_said() -> None:
    rig = imported_rig("lab.csv", 3, 200.0)
    assert (rig.mechanism, rig.dof, rig.rate, rig.torque) == ("delta", 3, 200.0, Torque())
    assert imported_rig("lab.csv", 3, 200.0, mechanism="axes").joint_types == ("revolute",) * 3
    axes = imported_rig("bench.csv", 2, 100.0, joints=("prismatic",), torque=Torque(map="linear"))
    assert (axes.joint_types, axes.torque.gain) == (("prismatic", "prismatic"), (1.0, 1.0))
    assert Rig.model_validate_json(axes.model_dump_json()) == axes


@pytest.mark.parametrize(
    ("dof", "options", "reason"),
    [
        (2, {"mechanism": "delta"}, "three revolute joints expected for a delta robot, 2 revolute found"),
        (3, {"joints": ("prismatic",)}, "3 prismatic found; choose axes"),
        (3, {"mechanism": "axes", "joints": ("revolute", "prismatic")}, "one kind of joint for all, or 3"),
        (2, {"torque": Torque(gain=(1.0,))}, "torque.gain needs 2 numbers, 1 found"),
        (1, {"rate": -1.0}, "'rate'"),
        (2, {"gravity": True}, "--gravity is for a single axis, 2 joints found"),
        (2, {"torque": measured_torque(2, (0.1,))}, "torque.per_ampere: none or 2 expected, 1 found"),
    ],
)
def test_inconsistent_options_are_refused(dof: int, options: dict[str, Any], reason: str) -> None:
    with pytest.raises(BadInput, match=reason):
        imported_rig("x.csv", dof, **{"rate": 100.0} | options)
