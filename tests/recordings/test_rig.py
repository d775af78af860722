"""Rig description: defaults, refused values and the JSON round trip."""

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from recordings.errors import BadInput
from recordings.rig import Drive, Rig, load_rig, simulated_rig

DRIVES = "".join(f"[[drives]]\nnode_id = {i}\n" for i in (1, 2, 3))

AXES = 'name = "r"\nmechanism = "axes"\n'


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
        ('name = "r"\nspeed = 1\n' + DRIVES, "unknown key 'speed'"),
        (DRIVES, "key 'name' is missing"),
        ('name = "r"\nrate = "fast"\n' + DRIVES, "'rate': .*found 'fast'"),
        ('name = "r"\nrate = 0\n' + DRIVES, "'rate': .*greater than 0.*found 0"),
        ('name = "r"\n[limits]\nspeed = nan\n' + DRIVES, "'limits.speed'"),
        ('name = "r"\n' + DRIVES.replace("2", "1"), "node_id, 1 stands in two"),
        ('name = "r"\n' + DRIVES.replace("3", "128"), r"'drives\.2\.node_id': .*127.*found 128"),
        ('name = "r"\n[[drives]]\nnode_id = 1\n', "three .*drives.*, 1 found"),
        ('name = "r"\n' + DRIVES + "[torque]\ngain = [1.0, 2.0]\n", "torque.gain needs 3 numbers, 2 found"),
        ('name = "r"\n' + DRIVES + "[geometry]\nL2 = 0.4\n", "too short to close .*L2 = 0.4 m found"),
        ('name = "r"\n' + DRIVES + "[limits]\njoint_min = 2.0\n", "joint_min < joint_max expected, 2 and 1.4 found"),
        ('name = "r"\n' + DRIVES + "[limits]\nworkspace_z = [-0.4, -1.0]\n", r"\[lowest, highest\] expected"),
        ("name = ", "not valid TOML"),
        ('name = "r"\n', "one of .*drives.* for each of 3 joints expected, none found"),
        ('name = "r"\n[[axes]]\n' + DRIVES, 'belong to the mechanism "axes", "delta" found'),
        (AXES, r'mechanism "axes" needs an \[\[axes\]\] section'),
        (AXES + "[[axes]]\n" + DRIVES, r"1 \[\[axes\]\] have as many \[\[drives\]\], 3 found"),
        (AXES + "[[axes]]\n[geometry]\nL2 = 0.9\n", r"\[geometry\] describes a delta robot"),
        (AXES + '[[axes]]\ntype = "screw"\n', r"'axes\.0\.type'.*screw"),
        (AXES + "[[axes]]\n[torque]\ngain = [1.0, 2.0]\n", "torque.gain needs 1 numbers, 2 found"),
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


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ('units = { acceleration = "rpm" }', r"units.acceleration: counts/s\^2, rpm/s.*'rpm' found"),
        ('units = { acceleration = "0 rpm/s" }', "'0 rpm/s' found"),
        ('units = { acceleration = "nan rpm/s" }', "'nan rpm/s' found"),
        ('accept_missing = ["606"]', "such as 6066 expected, '606' found"),
        ("homed = { index = 0x6041, mask = 0x10000 }", "16-bit statusword.*0x10000 found"),
        ("quick_stop_option = 3", "quick_stop_option.*1, 2, 5 or 6"),
        ('torque_source = "current_actual"', "one torque_source for all drives expected"),
    ],
)
def test_invalid_key_of_a_drive_is_explained(line: str, reason: str, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=reason):
        load(tmp_path, 'name = "r"\n' + DRIVES + line + "\n")


def test_current_as_torque_source_needs_its_scale(tmp_path: Path) -> None:
    text = AXES + '{}\n[[axes]]\n[[drives]]\nnode_id = 1\ntorque_source = "current_actual"\n{}\n'
    with pytest.raises(BadInput, match="needs rated_current"):
        load(tmp_path, text.format("", ""))
    with pytest.raises(BadInput, match=r"needs torque\.per_ampere"):
        load(tmp_path, text.format("", "rated_current = 4.2"))
    rig = load(tmp_path, text.format("torque = { per_ampere = [2.4] }", "rated_current = 4.2"))
    assert rig.drives[0].rated_current == 4.2
