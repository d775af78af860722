"""The end of a run: what is written to each drive, also where another does not answer."""

from collections import defaultdict

import numpy as np
import pytest

from drivers.protocol import Goal, Power
from recordings.rig import Drive, Limits, Rig
from tests.drivers.canopen.lossy_bus import LossyBus, reach
from tests.failures import assert_safe
from tests.patience import patient

QUICK_STOP, OFF, NO_OFFSET, NO_WATCHDOG = "6040:0002", "6040:0000", "60B2:0000", "1016:00000000"
RIG = Rig(
    name="three drives",
    rate=200.0,
    limits=Limits(torque_offset=0.5),
    drives=(Drive(node_id=1), Drive(node_id=2), Drive(node_id=3, torque_offset=True)),
)


@pytest.mark.timeout(patient(60))
def test_every_drive_that_answers_is_stopped_off_and_without_a_watchdog_and_the_silent_one_named() -> None:
    bus, reports, written = LossyBus(RIG), [], defaultdict[int, list[str]](list)
    driver = bus.driver(lambda *line: reports.append(line))
    driver.discover()
    driver.configure()
    reach(driver, Goal.ENABLED, Power.ON)
    for code, times in ((0xFF01, 3), (0x8140, 1)):
        for _ in range(times):
            bus.drives[0].warn(code)
    start = np.array([drive.generator.position for drive in bus.drives])
    for setpoint in driver.encode(start + 0.005 * np.arange(1, 6)[:, None]):  # at 1 rad/s
        driver.exchange(setpoint, 0.01)
    bus.drives[1].receive = lambda *frame: None  # type: ignore[method-assign]
    for axis in driver._axes:
        axis.sdo._client.RESPONSE_TIMEOUT = 0.001

    def note(arbitration_id: int, data: bytes) -> None:
        if arbitration_id & 0x780 == 0x600 and data[0] & 0xE0 == 0x20:
            value = data[4 : 8 - (data[0] >> 2 & 3)][::-1].hex()
            written[arbitration_id & 0x7F].append(f"{data[2]:02X}{data[1]:02X}:{value}")
            assert written[1][-1] != OFF or not bus.drives[0].powered, "switched off while it moves"

    reports.clear()
    bus.witness = note
    assert driver.power_off() == (Power.OFF, Power.UNKNOWN, Power.OFF)
    driver.close()
    assert bus.enabled == [2]
    assert written[1] == [QUICK_STOP, OFF, OFF, NO_WATCHDOG]
    assert written[2] == [QUICK_STOP, OFF, OFF]
    assert written[3] == [NO_OFFSET, QUICK_STOP, NO_OFFSET, OFF, OFF, NO_OFFSET, NO_WATCHDOG]
    came_again, load, *errors = sorted(reports, key=lambda line: line[0] == "error")
    assert came_again[1:] == ("joint 1 (node 1)", "3 times: EMCY 0xFF01: the manufacturer's own code")
    assert "load of the bus" in load[2]
    assert [text.split(":")[0] for _, _, text in errors] == ["while switching power off"] * 2 + ["while closing"]
    assert {source for _, source, _ in errors} == {"joint 2 (node 2)"}
    bus.wait(1.0)
    assert_safe(not bus.enabled, "the watchdog of the silent one")
