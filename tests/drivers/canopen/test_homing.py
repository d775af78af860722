"""Homing of one drive: what is written, when it starts, and which statuswords are believed."""

from typing import Any

import pytest

from drivers.canopen.homing import HomingState, homing_writes
from drivers.protocol import Goal, Power
from drivers.simulated.habits import Habits
from recordings.config import validated
from recordings.errors import BadInput
from recordings.rig import Drive, Homing, Rig, simulated_rig
from tests.drivers.canopen.given import dictionary, values_of
from tests.drivers.canopen.lossy_bus import LossyBus, reach

HOMED = {"index": 0x6041, "mask": 0x8000}
HABITS = Habits(referenced_mask=0x8000, referenced=False)


@pytest.mark.parametrize(
    ("homing", "habits", "end", "least"),
    [
        ({"method": 17, "speed": 0.5}, HABITS, HomingState.DONE, 0.02 / 0.5 * 500 - 4),
        # Method 35 is done at once; the drive says "attained" from the start, and may mean an earlier homing.
        ({"method": 35}, Habits(), HomingState.DONE, 0.4 * 500),
        ({"method": 17}, Habits(values={"6099:1": 0}), HomingState.FAILED, 0),
    ],
)
def test_states_of_a_homing_are_not_those_of_an_earlier_one(
    homing: dict[str, Any], habits: Habits, end: HomingState, least: float
) -> None:
    drives = [{"node_id": 1, "homing": homing, "homed": HOMED}, {"node_id": 2}, {"node_id": 3}]
    rig = validated(simulated_rig().model_dump(mode="json") | {"drives": drives}, Rig, "rig")
    bus = LossyBus(rig, habits=habits)
    driver = bus.driver()
    driver.discover()
    driver.configure(referenced=False)
    search = driver.homing(1)
    search.prepare(Homing(**homing))
    reach(driver, Goal.ENABLED, Power.ON)
    search.start()
    states = [HomingState.RUNNING]
    while states[-1] is HomingState.RUNNING and len(states) < 1000:
        assert driver.exchange(None, 0.01).trouble is None
        states.append(search.state())
    assert states[-1] is end
    assert len(states) > least
    reach(driver, Goal.DISABLED, Power.OFF)
    search.finish()
    assert driver.is_homed(1) == (habits is HABITS)
    driver.close()
    assert not bus.enabled


def test_speeds_are_written_in_the_units_of_the_drive_which_must_be_known() -> None:
    drive, speed = Drive(node_id=1, counts_per_turn=8192, gear=21.0), Homing(method=17, speed=0.1, acceleration=1.0)
    rpm = dictionary(drive, {(0x60A9, 0): bytes.fromhex("0047b400")})
    assert values_of(homing_writes(speed, rpm, "joint 1")) == {
        (0x6098, 0): 17,
        (0x6099, 1): round(0.1 * 21 * 60 / 6.283185307),
        (0x609A, 0): round(8192 * 21 / 6.283185307),
    }
    with pytest.raises(BadInput, match="60A9h"):
        homing_writes(speed, dictionary(drive), "joint 1")
    assert len(homing_writes(Homing(method=17), dictionary(drive), "joint 1")) == 1
