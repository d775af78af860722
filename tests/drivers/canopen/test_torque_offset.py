"""The torque offset 60B2h on the bus: thousandths of the rated torque, in the drive's direction, 0 unless given."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from drivers.canopen.bus import Link
from drivers.canopen.drive import CanopenDrives
from recordings.rig import Drive, Limits, Rig
from tests.drivers.canopen.given import dictionary
from tests.drivers.canopen.scripted import ScriptedBus

RIG = Rig(
    name="r",
    limits=Limits(torque_offset=0.5),
    drives=tuple(Drive(node_id=i, sign=sign, torque_offset=True) for i, sign in ((1, 1), (2, -1), (3, 1))),
)
NEUTRAL = [((0x200 + node, "00 00 00 00 00 00 00 00"), []) for node in (1, 2, 3)]


def test_offset_follows_the_target_in_units_of_the_drive_and_is_zero_without_a_torque_and_while_holding() -> None:
    drives = CanopenDrives(RIG, Link(ScriptedBus([*NEUTRAL, ((0x77F, "05"), []), ((0x80, ""), [])])), print)
    torque = np.array([[2.0, 2.0, -1.0]])
    (setpoint,) = drives.encode(np.zeros((1, 3)), torque)
    # 2 N m of 20 N m: 100 thousandths.
    assert [data.hex(" ") for data in setpoint] == ["00 00 00 00 64 00", "00 00 00 00 9c ff", "00 00 00 00 ce ff"]
    (setpoint,) = drives.encode(np.ones((1, 3)))
    assert all(data.endswith(b"\0\0") and len(data) == 6 for data in setpoint)
    drives.exchange(None, 0.0)
    for axis in drives._axes:
        axis.use(dictionary(axis.drive, {(0x6076, 0): 1900}))
    (setpoint,) = drives.encode(np.zeros((1, 3)), 1.995 * torque)
    assert int.from_bytes(setpoint[0][4:], "little") == 100


@given(st.lists(st.floats(-1e6, 1e6), min_size=3, max_size=3))
def test_offset_never_exceeds_its_limit(torque: list[float]) -> None:
    counts = RIG.torque_offset_counts(np.array([torque]))
    assert np.abs(counts).max() <= 500
    assert (np.sign(counts[0]) * np.sign(torque) * [1, -1, 1] >= 0).all()
