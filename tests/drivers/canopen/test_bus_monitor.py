"""Another master on the bus, answers that do not fit, and faults without EMCY: each is named as what it is."""

import pytest

from drivers.canopen.drive import CanopenDrives
from drivers.protocol import Goal, Power, Sample
from drivers.simulated.habits import Habits
from drivers.simulated.mark import EDS
from recordings.rig import Axis, Drive, Rig, Torque
from tests.drivers.canopen.lossy_bus import LossyBus

RIG = Rig(
    name="two axes",
    mechanism="axes",
    axes=(Axis(), Axis()),
    drives=(Drive(node_id=1), Drive(node_id=2)),
    torque=Torque(gain=(1.0, 1.0)),
)
CYCLES = 100


class Enabled:
    """Two drives under power, with what was reported."""

    def __init__(self, habits: Habits | None = None) -> None:
        self.log: list[tuple[str, str]] = []
        self.bus = LossyBus(RIG, EDS, habits)
        self.driver: CanopenDrives = self.bus.driver(lambda level, source, text: self.log.append((level, text)))
        self.driver.discover()
        self.driver.configure()
        self.driver.goal = Goal.ENABLED
        while self.exchange().power != (Power.ON, Power.ON):
            assert self.bus.now < 1.0

    def exchange(self) -> Sample:
        return self.driver.exchange(None, 0.01)

    def until_wrong(self) -> Sample:
        """The first sample with a trouble or a missing answer."""
        for _ in range(CYCLES):
            sample = self.exchange()
            if sample.trouble or sample.missing:
                return sample
        raise AssertionError("nothing was wrong")


@pytest.mark.parametrize(
    ("trouble", "named", "details"),
    [
        (
            "silent_fault",
            "joint 1 (node 1): drive fault without EMCY",
            "603F:00 says 0x2310 (continuous over-current)",
        ),
        ("nmt_stop", 'NMT "stop" to joint 1 (node 1), sent by another master (COB-ID 000h)', ""),
        ("short_tpdo", "its TPDO (COB-ID 181h) has 7 bytes, 8 are mapped", ""),
    ],
)
def test_a_drive_with_trouble_says_which(trouble: str, named: str, details: str) -> None:
    run = Enabled(Habits.model_validate({"trouble": trouble, "trouble_after": 0.1}))
    sample = run.until_wrong()
    assert named in (sample.trouble or (sample.absence or ("",))[0])
    run.driver.goal = Goal.DISABLED
    run.driver.power_off()
    assert details in run.driver.fault_details()
    run.driver.close()
    assert not run.bus.enabled


def test_a_node_that_says_that_it_is_stopped_is_not_called_silent() -> None:
    run = Enabled()
    run.bus.to_drives(0x000, bytes([0x02, 2]))  # the master does not hear this frame
    run.bus.wait(0.2)
    sample = run.exchange()
    assert sample.absence is not None
    assert sample.absence[0] == ""
    assert "heartbeat (COB-ID 702h) says that it is stopped" in sample.absence[1]


@pytest.mark.parametrize(
    ("arbitration_id", "data", "named"),
    [
        (0x080, "", "a second SYNC"),
        (0x202, "0F 00 00 00 00 00", "an RPDO that commands joint 2 (node 2)"),
        (0x000, "02 01", 'NMT "stop" to joint 1 (node 1)'),
        (0x000, "81 00", 'NMT "reset" to all nodes'),
        (0x601, "2B 40 60 00 06 00 00 00", "an SDO write to joint 1 (node 1) 6040:00"),
    ],
)
def test_a_command_of_another_master_ends_the_run(arbitration_id: int, data: str, named: str) -> None:
    run = Enabled()
    run.bus._answer(arbitration_id, bytes.fromhex(data))
    text = f"{named}, sent by another master (COB-ID {arbitration_id:03X}h); disconnect it"
    assert run.exchange().trouble == text
    assert run.exchange().trouble == text
    assert run.log == [("error", text)]


@pytest.mark.parametrize(
    ("arbitration_id", "data", "warned"),
    [
        (0x77F, "05", "a master's heartbeat"),
        (0x601, "40 41 60 00 00 00 00 00", "an SDO request to joint 1 (node 1) 6041:00"),
        (0x000, "01 00", 'NMT "start" to all nodes'),
        (0x000, "02 09", ""),
        (0x205, "0F 00", ""),
        (0x605, "2B 40 60 00 06 00 00 00", ""),
        (0x705, "05", ""),
    ],
)
def test_what_endangers_nothing_is_at_most_a_warning(arbitration_id: int, data: str, warned: str) -> None:
    run = Enabled()
    for _ in range(3):
        run.bus._answer(arbitration_id, bytes.fromhex(data))
        assert run.exchange().trouble is None
    assert [level for level, _ in run.log] == (["warning"] if warned else [])
    assert all(text.startswith(warned) for _, text in run.log)
