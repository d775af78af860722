"""Homing of one drive: what is written, when it starts, and which statuswords are believed."""

from typing import Any

import pytest

from drivers.canopen.drive import CanopenDrives
from drivers.canopen.homing import homing_writes
from drivers.protocol import Goal, HomingState, Power
from drivers.simulated.habits import Habits
from recordings.config import validated
from recordings.errors import BadInput, RunFailed
from recordings.rig import Drive, Homing, Rig, simulated_rig
from tests.drivers.canopen.given import dictionary, values_of
from tests.drivers.canopen.lossy_bus import LossyBus

HOMED = {"index": 0x6041, "mask": 0x8000}
HABITS = Habits(referenced_mask=0x8000, referenced=False)


def rig_with(**keys: Any) -> Rig:
    drives = [{"node_id": 1, **keys}, {"node_id": 2}, {"node_id": 3}]
    return validated(simulated_rig().model_dump(mode="json") | {"drives": drives}, Rig, "rig")


def drives_of(rig: Rig, habits: Habits = HABITS) -> tuple[CanopenDrives, LossyBus]:
    bus = LossyBus(rig, habits=habits)
    driver = bus.driver()
    driver.discover()
    return driver, bus


def search(driver: CanopenDrives, cycles: int = 1000) -> list[HomingState]:
    """Enable, start, exchange until the end; states in the order of the answers."""
    driver.goal = Goal.ENABLED
    while driver.exchange(None, 0.01).power != (Power.ON,) * 3:
        pass
    driver.start_homing(1)
    states = []
    for _ in range(cycles):
        sample = driver.exchange(None, 0.01)
        assert sample.trouble is None
        states.append(driver.homing_state(1))
        if states[-1] is not HomingState.RUNNING:
            break
    driver.goal = Goal.DISABLED
    driver.exchange(None, 0.01)
    driver.exchange(None, 0.01)
    return states


def test_drive_without_reference_is_homed_and_then_runs() -> None:
    rig = rig_with(homing={"method": 17, "speed": 0.5}, homed=HOMED)
    driver, bus = drives_of(rig)
    with pytest.raises(RunFailed, match="home the drive first"):
        driver.configure()
    driver.configure(referenced=False)
    assert not driver.is_homed(1)
    start = bus.drives[0].generator.position
    driver.prepare_homing(1)
    states = search(driver)
    assert states[-1] is HomingState.DONE
    assert len(states) == pytest.approx(0.02 / 0.5 * rig.rate, abs=4)
    assert bus.drives[0].generator.position == pytest.approx(start + 0.02, abs=1e-3)
    driver.finish_homing(1)
    assert driver.is_homed(1)
    assert bus.drives[0]._motion.mode == 8
    driver.close()
    assert not bus.enabled


@pytest.mark.parametrize(
    ("method", "habits", "end", "least"),
    [
        # Method 35 is done at once; the drive says "attained" from the start, and may mean an earlier homing.
        (35, Habits(), HomingState.DONE, 0.4 * 500),
        (17, Habits(values={"6099:1": 0}), HomingState.FAILED, 0),
    ],
)
def test_earlier_homing_is_not_taken_for_this_one_and_an_error_is_seen(
    method: int, habits: Habits, end: HomingState, least: float
) -> None:
    driver, _ = drives_of(rig_with(homing={"method": method}), habits)
    driver.configure(referenced=False)
    driver.prepare_homing(1)
    states = search(driver)
    assert states[-1] is end
    assert len(states) > least


def test_drive_without_homing_mode_is_refused() -> None:
    driver, _ = drives_of(rig_with(homing={"method": 17}), Habits(values={"6502": 0xC0}))
    driver.configure(referenced=False)
    with pytest.raises(BadInput, match="no mode 6"):
        driver.prepare_homing(1)


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
