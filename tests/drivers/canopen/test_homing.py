"""Homing of one drive: what is written, when it starts, and which statuswords are believed."""

from typing import Any

import pytest

from drivers.canopen.bus import Link
from drivers.canopen.dictionary import DriveDictionary, standard_dictionary
from drivers.canopen.drive import CanopenDrives
from drivers.canopen.homing import homing_writes
from drivers.protocol import Goal, HomingState, Power
from drivers.simulated.habits import Habits
from recordings.config import validated
from recordings.errors import BadInput, RunFailed
from recordings.rig import Drive, Homing, Rig, simulated_rig
from tests.drivers.canopen.lossy_bus import LossyBus

HOMED = {"index": 0x6041, "mask": 0x8000}
HABITS = Habits(referenced_mask=0x8000, referenced=False)


def rig_with(**keys: Any) -> Rig:
    drives = [{"node_id": 1, **keys}, {"node_id": 2}, {"node_id": 3}]
    return validated(simulated_rig().model_dump(mode="json") | {"drives": drives}, Rig, "rig")


def drives_of(rig: Rig, habits: Habits = HABITS) -> tuple[CanopenDrives, LossyBus]:
    bus = LossyBus(rig, habits=habits)
    link = Link(bus)
    link.clock = bus.now_ns
    driver = CanopenDrives(rig, link, lambda *line: None)
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


def test_earlier_homing_is_not_taken_for_this_one() -> None:
    driver, _ = drives_of(rig_with(homing={"method": 35}), Habits())
    driver.configure(referenced=False)
    driver.prepare_homing(1)
    states = search(driver)
    assert states[-1] is HomingState.DONE
    assert len(states) > 0.4 * 500  # method 35 is done at once: attained from the start


def test_homing_error_is_seen() -> None:
    driver, _ = drives_of(rig_with(homing={"method": 17}), Habits(values={"6099:1": 0}))
    driver.configure(referenced=False)
    driver.prepare_homing(1)
    assert search(driver)[-1] is HomingState.FAILED


def test_drive_without_homing_mode_is_refused() -> None:
    driver, _ = drives_of(rig_with(homing={"method": 17}), Habits(values={"6502": 0xC0}))
    driver.configure(referenced=False)
    with pytest.raises(BadInput, match="no mode 6"):
        driver.prepare_homing(1)


def test_speeds_are_written_in_the_units_of_the_drive() -> None:
    drive = Drive(node_id=1, counts_per_turn=8192, gear=21.0)
    rpm = DriveDictionary(drive, {**standard_dictionary(drive).data, (0x60A9, 0): bytes.fromhex("0047b400")})
    writes = homing_writes(Homing(method=17, speed=0.1, acceleration=1.0), rpm, "joint 1")
    assert [(write.index, write.sub) for write in writes] == [(0x6098, 0), (0x6099, 1), (0x609A, 0)]
    assert writes[1].value == round(0.1 * 21 * 60 / 6.283185307)
    assert writes[2].value == round(8192 * 21 / 6.283185307)


def test_speed_without_a_known_unit_is_refused() -> None:
    drive = Drive(node_id=1)
    with pytest.raises(BadInput, match="60A9h"):
        homing_writes(Homing(method=17, speed=0.1), standard_dictionary(drive), "joint 1")
    assert len(homing_writes(Homing(method=17), standard_dictionary(drive), "joint 1")) == 1
