"""The torque offset 60B2h on the bus: thousandths of the rated torque, in the drive's direction, 0 unless given."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.canopen import setup
from drivers.canopen.bus import Link
from drivers.canopen.dictionary import DriveDictionary, standard_dictionary
from drivers.canopen.drive import CanopenDrives
from drivers.canopen.load import bus_load
from recordings.rig import Drive, Limits, Rig, simulated_rig
from tests.drivers.canopen.scripted import ScriptedBus

RIG = Rig(
    name="r",
    limits=Limits(torque_offset=0.5),
    drives=tuple(Drive(node_id=i, sign=sign, torque_offset=True) for i, sign in ((1, 1), (2, -1), (3, 1))),
)


def _drives(script: list[tuple[tuple[int, str], list[tuple[int, str]]]]) -> CanopenDrives:
    return CanopenDrives(RIG, Link(ScriptedBus(script)), lambda *entry: None)


def test_offset_follows_the_target_in_the_frame() -> None:
    (setpoint,) = _drives([]).encode(np.zeros((1, 3)), np.array([[2.0, 2.0, -1.0]]))
    # 2 N m of 20 N m: 100 thousandths.
    assert [data.hex(" ") for data in setpoint] == ["00 00 00 00 64 00", "00 00 00 00 9c ff", "00 00 00 00 ce ff"]


def test_without_a_torque_and_while_holding_the_offset_is_zero() -> None:
    (setpoint,) = _drives([]).encode(np.ones((1, 3)))
    assert all(data.endswith(b"\0\0") and len(data) == 6 for data in setpoint)
    frames = [((0x200 + node, "00 00 00 00 00 00 00 00"), []) for node in (1, 2, 3)]
    _drives([*frames, ((0x77F, "05"), []), ((0x80, ""), [])]).exchange(None, 0.0)


@given(st.lists(st.floats(-1e6, 1e6), min_size=3, max_size=3))
def test_offset_never_exceeds_its_limit(torque: list[float]) -> None:
    counts = RIG.torque_offset_counts(np.array([torque]))
    assert np.abs(counts).max() <= 500
    assert (np.sign(counts[0]) * np.sign(torque) * [1, -1, 1] >= 0).all()


def test_rated_torque_is_that_of_the_drive_where_it_states_one() -> None:
    drives = _drives([])
    for axis in drives._axes:
        data = {**standard_dictionary(axis.drive).data, (0x6076, 0): (1900).to_bytes(4, "little")}
        axis.use(DriveDictionary(axis.drive, data))
    (setpoint,) = drives.encode(np.zeros((1, 3)), np.array([[3.99, 0.0, 0.0]]))
    assert int.from_bytes(setpoint[0][4:], "little") == 100


def test_bus_load_grows_by_two_bytes_per_drive() -> None:
    rig = simulated_rig()
    # 16 data bits and up to 4 stuffed ones.
    more = bus_load(rig.with_torque_offset(), 500.0) - bus_load(rig, 500.0)
    assert more == pytest.approx(3 * 20 * 500 / 1e6)


def test_offset_that_a_killed_run_left_is_cleared_in_any_run() -> None:
    drive = Drive(node_id=1)
    data = dict(standard_dictionary(drive).data)
    for stored, written in ((0, False), (-250, True)):
        dictionary = DriveDictionary(drive, {**data, (0x60B2, 0): stored.to_bytes(2, "little", signed=True)})
        writes = [write for write in setup.own_writes(simulated_rig(), drive, dictionary) if write.index == 0x60B2]
        assert bool(writes) is written
        assert all(write.value == 0 for write in writes)
