import json
import math

import numpy as np
import pytest

from drivers.canopen.axis import CanopenAxis
from drivers.canopen.bus import Link
from drivers.canopen.pdo import bus_load
from drivers.canopen.poll import VoltagePoll
from drivers.protocol import Goal, Power
from drivers.simulated.habits import Habits
from drivers.simulated.mark import EDS
from recordings.rig import Axis, Drive, Rig, Torque, Voltage
from tests.drivers.canopen.lossy_bus import LossyBus, reach
from tests.drivers.canopen.scripted import ScriptedBus


@pytest.mark.parametrize(
    ("answer", "signed", "volts"),
    [
        ("43 30 20 00 70 11 01 00", None, 70.0),  # four bytes: 70,000
        ("43 30 20 00 90 ee fe ff", None, -70.0),
        ("4b 30 20 00 f0 d8 00 00", None, -10.0),  # two bytes
        ("4b 30 20 00 f0 d8 00 00", False, 55.536),
        ("4f 30 20 00 fe 00 00 00", None, -0.002),  # one byte
        ("42 30 20 00 f0 d8 00 00", None, -10.0),  # size not indicated: that of the dictionary
        ("80 30 20 00 00 00 02 06", None, math.nan),  # an abort
        ("43 31 20 00 70 11 01 00", None, math.nan),  # of another object
        ("41 30 20 00 09 00 00 00", None, math.nan),  # in segments
    ],
)
def test_voltage_by_the_answer_to_a_poll(answer: str, signed: bool | None, volts: float) -> None:
    """1 mV per count."""
    voltage = Voltage(index=0x2030, sub=0, scale=0.001, transfer="sdo", signed=signed)
    drives = (Drive(node_id=1, voltage=voltage),)
    rig = Rig(name="axis", mechanism="axes", axes=(Axis(),), drives=drives, torque=Torque(gain=(1.0,)))
    link = Link(ScriptedBus([((0x601, "40 30 20 00 00 00 00 00"), [])]))
    axis = CanopenAxis(rig, 1, link, lambda *frame: None)
    poll = VoltagePoll([axis], link)
    poll.request(0)
    poll.take_response([axis], bytes.fromhex(answer))
    assert axis.voltage == pytest.approx(volts, nan_ok=True)


@pytest.mark.parametrize("transfer", ["pdo", "sdo"])
def test_changes_of_a_watched_state_are_reported(transfer: str) -> None:
    """A number with its sign, and bits."""
    watched = [{"index": 0x6060}, {"index": 0x6041, "mask": 0x6F, "name": "state"}]
    keys = {"node_id": 1, "voltage": {"transfer": transfer}, "watched": watched}
    drives = (Drive.model_validate_json(json.dumps(keys)),)
    rig = Rig(name="axis", mechanism="axes", axes=(Axis(),), drives=drives, torque=Torque(gain=(1.0,)))
    assert bus_load(rig, 500.0) > bus_load(rig.model_copy(update={"drives": (Drive(node_id=1),)}), 500.0)
    bus, log = LossyBus(rig), list[tuple[str, ...]]()
    driver = bus.driver(lambda *report: log.append(report))
    driver.discover()
    driver.configure()
    for _ in range(20):
        driver.exchange(None, 0.01)
    reach(driver, Goal.ENABLED, Power.ON)
    volts = [driver.exchange(None, 0.01).voltage[0] for _ in range(20)]
    driver.close()
    assert not all(map(math.isnan, volts))
    states = [text for _, source, text in log if source == "joint 1 (node 1)"]
    assert states[:2] == ["6060:00 = 8", "state 6041:00 = 0x40"]
    assert states[-1].startswith("state 6041:00 = 0x27, was 0x")


@pytest.mark.parametrize("unit", [0x00B5_0300, 0xFDB4_4700, 0])
@pytest.mark.parametrize("transfer", ["pdo", "sdo"])
def test_velocity_actual_is_polled_in_the_unit_that_the_drive_states(unit: int, transfer: str) -> None:
    """Increments/s, thousandths of rpm, or none; beside the voltages that are polled, and without any."""
    drives = (Drive.model_validate({"node_id": 1, "sign": -1, "voltage": {"transfer": transfer}}),)
    rig = Rig(name="axis", mechanism="axes", axes=(Axis(),), drives=drives, torque=Torque(gain=(1.0,)))
    bus = LossyBus(rig, EDS, Habits(values={"60A9": unit}))
    bus.volts = 2.0
    driver = bus.driver()
    driver.discover()
    velocity = driver.poll_velocity(1)
    driver.configure()
    reach(driver, Goal.ENABLED, Power.ON)
    targets = np.minimum(np.arange(150) / 1000, 0.1)[:, None]
    volts = [driver.exchange(setpoint, 0.01).voltage[0] for setpoint in driver.encode(targets)]
    driver.close()
    assert {volt for volt in volts if not math.isnan(volt)} == {2.0}
    assert (velocity is None) == (unit == 0)
    if velocity is not None:
        way = np.trapezoid(velocity.values, np.array(velocity.stamps) * 1e-9) * velocity.unit
        assert way == pytest.approx(0.1, rel=0.01)
