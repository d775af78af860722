"""Another master on the bus, answers that do not fit, and faults without EMCY: each is named as what it is."""

from collections import deque

import pytest

from drivers.canopen.drive import CanopenDrives
from drivers.canopen.kernel_sync import KernelSync
from drivers.protocol import Goal, Power, Sample
from drivers.simulated.habits import Habits
from drivers.simulated.mark import EDS
from recordings.rig import Axis, Drive, Rig, Torque
from tests.drivers.canopen.lossy_bus import LossyBus, reach

RIG = Rig(
    name="two axes",
    mechanism="axes",
    axes=(Axis(), Axis()),
    drives=(Drive(node_id=1), Drive(node_id=2)),
    torque=Torque(gain=(1.0, 1.0)),
)
CYCLES, SETTLED = 100, 60
"""Cycles of a test; cycles after which no answer counts as late."""


class Enabled:
    """Two drives under power, with what was reported."""

    def __init__(self, habits: Habits | None = None) -> None:
        self.log: list[tuple[str, str]] = []
        self.bus = LossyBus(RIG, EDS, habits)
        self.driver: CanopenDrives = self.bus.driver(lambda level, source, text: self.log.append((level, text)))
        self.driver.discover()
        self.driver.configure()
        reach(self.driver, Goal.ENABLED, Power.ON)

    def exchange(self) -> Sample:
        return self.driver.exchange(None, 0.01)

    def run(self, cycles: int) -> None:
        """Cycles in which no drive has trouble."""
        for _ in range(cycles):
            assert self.exchange().trouble is None

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
        ("sync_loss", "joint 1 (node 1): drive fault, synchronisation with SYNC (0x8700)", ""),
        ("limit_switch", "joint 1 (node 1): internal limit active (statusword bit 11), and the target is not", ""),
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


@pytest.mark.parametrize("answers", [0, 1])
def test_a_heartbeat_older_than_the_last_answer_or_than_the_start_explains_no_silence(answers: int) -> None:
    """On a busy host both are read late: the heartbeat is of a time in which the node was pre-operational."""
    bus = LossyBus(RIG, EDS)
    driver = bus.driver(lambda *line: None)
    driver.discover()
    driver.configure()
    bus._answer(0x702, b"\x7f")
    for _ in range(answers):
        assert driver.exchange(None, 0.01).missing == 0
    bus.losses["tpdo"] = 2
    assert driver.exchange(None, 0.01).absence == ("", "")


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


def test_a_second_answer_of_a_joint_ends_the_run() -> None:
    """A frame that CAN repeats, with the same content, does not."""
    run = Enabled()
    run.bus.doubles["tpdo"] = 3
    run.run(SETTLED)
    run.bus._answer(0x182, bytes.fromhex("27 06 FF FF FF 7F 00 00"))
    assert run.exchange().trouble == (
        "a second TPDO of joint 2 (node 2) in one cycle, sent by another node (COB-ID 182h); disconnect it"
    )


@pytest.mark.parametrize("late", [0, 120])
def test_answers_that_come_late_are_not_those_of_another_node(late: int) -> None:
    """A busy host takes each answer one cycle later, for `late` cycles, until two come in one."""
    run = Enabled()
    run.run(SETTLED)
    run.bus.losses["tpdo"] = 2
    assert run.exchange().missing == 2
    run.run(late)
    for arbitration_id in (0x181, 0x182):
        run.bus._answer(arbitration_id, bytes.fromhex("27 06 01 00 00 00 00 00"))
    assert run.exchange().trouble is None


def test_a_kernel_that_sends_sync_is_told_from_a_second_master() -> None:
    kernel = KernelSync.__new__(KernelSync)
    kernel._period, kernel._stamp, kernel._pacer, kernel.second = 0.002, 0.0, None, False
    kernel._on_sync_frame(1.0, received=False)
    assert not kernel.second
    kernel._on_sync_frame(1.0005, received=True)
    assert kernel.second


@pytest.mark.parametrize(
    ("heard", "seen"),
    [(b"\x00", "a boot-up message"), (b"\x7f", "heartbeats too fast"), (b"\x05", "heartbeats too fast")],
)
def test_a_node_id_that_is_there_twice_is_a_warning(heard: bytes, seen: str) -> None:
    run = Enabled()
    run.run(SETTLED)
    for _ in range(2):
        run.bus._answer(0x702, heard)
        run.run(5)
    (warning,) = [text for level, text in run.log if level == "warning"]
    assert warning.startswith(f"node id 2 is there twice: {seen} (COB-ID 702h)")


def test_a_long_answer_is_used_and_named() -> None:
    run = Enabled(Habits.model_validate({"trouble": "long_tpdo", "trouble_after": 0.1}))
    for _ in range(CYCLES):
        sample = run.exchange()
        assert (sample.trouble, sample.missing) == (None, 0)
    assert [text.partition(":")[2] for _, text in run.log] == [
        f" its TPDO (COB-ID {cob_id}h) has 9 bytes, 8 are mapped" for cob_id in (181, 182)
    ]


def test_a_limit_of_the_drive_is_named_once() -> None:
    run = Enabled(Habits.model_validate({"referenced_mask": 0x800}))
    run.run(3)
    assert [text.partition(":")[0] for _, text in run.log if "bit 11" in text] == [
        "joint 1 (node 1)",
        "joint 2 (node 2)",
    ]


def test_a_full_bus_is_named_within_a_tenth_of_a_second() -> None:
    run = Enabled()
    run.run(SETTLED)
    for _ in range(round(0.1 * RIG.rate)):
        for number in range(20):
            run.bus._answer(0x300 + number, bytes(8))
        run.run(1)
    assert run.log[0][0] == "warning"
    assert "the bus is full" in run.log[0][1]


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
        run.run(1)
    named = f"{warned}, sent by another master (COB-ID {arbitration_id:03X}h); disconnect it"
    assert run.log == ([("warning", named)] if warned else [])


def test_our_own_frames_that_come_back_are_not_named() -> None:
    """As on udp_multicast, which does not mark them."""
    run = Enabled()
    run.driver._link._expected_echoes = deque(maxlen=100)
    run.bus.witness = run.bus._answer
    run.run(CYCLES)
    assert run.driver._link.echoes > 3 * CYCLES
    assert run.log == []
