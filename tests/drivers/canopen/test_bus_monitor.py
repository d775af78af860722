"""Another master on the bus, answers that do not fit, and faults without EMCY: each is named as what it is."""

import re
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any

import can
import pytest

from drivers.canopen import can_errors
from drivers.canopen.drive import CanopenDrives
from drivers.canopen.kernel_sync import KernelSync
from drivers.canopen.presence import Presence
from drivers.protocol import Goal, Power, Sample
from drivers.simulated.habits import Habits
from drivers.simulated.mark import EDS
from recordings.rig import Axis, Drive, Rig, Torque
from tests.drivers.canopen.lossy_bus import LossyBus, reach
from tests.faults.habits import guarded_without_heartbeat

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

    def __init__(
        self, habits: Habits | None = None, *, eds: Path = EDS, bus: Callable[..., LossyBus] = LossyBus
    ) -> None:
        self.log: list[tuple[str, str]] = []
        self.bus = bus(RIG, eds, habits)
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

    def until_wrong(self, cycles: int = CYCLES) -> Sample:
        """The first sample with a trouble or a missing answer."""
        for _ in range(cycles):
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
    foreign: list[bool] = []
    kernel = KernelSync.__new__(KernelSync)
    kernel._period, kernel._stamp, kernel._pacer, kernel.on_sync = 0.002, 0.0, None, foreign.append
    kernel._on_sync_frame(1.0, received=False)
    kernel._on_sync_frame(1.0005, received=True)
    assert foreign == [False, True]


def _heartbeats(run: Enabled, data: bytes, interval: float, phase: float, cycles: int) -> Sample | None:
    """Cycles in which node 2 is heard once more at this interval [s]; returns the first sample with a trouble."""
    every, first = round(interval * RIG.rate), round(phase * RIG.rate)
    for k in range(cycles):
        if k % every == first:
            run.bus._answer(0x702, data)
        if (sample := run.exchange()).trouble:
            return sample
    return None


@pytest.mark.parametrize(
    ("heard", "interval", "within", "seen"),
    [
        (b"\x00", 10.0, 3, "a boot-up message"),
        (b"\x7f", 10.0, 3, "a heartbeat that says pre-operational"),
        (b"\x04", 10.0, 3, "a heartbeat that says stopped"),
        (b"\x05", 0.1, 500, "twice as many heartbeats"),
        (b"\x05", 0.01, 60, "twice as many heartbeats"),
    ],
)
def test_a_second_node_that_appears_ends_the_run(heard: bytes, interval: float, within: int, seen: str) -> None:
    run = Enabled()
    run.run(SETTLED)
    sample = _heartbeats(run, heard, interval, 0.0, within)
    assert sample is not None
    assert sample.trouble == (
        f"joint 2 (node 2): a second node has its id: {seen} (COB-ID 702h), and the drive goes on; change one id"
    )
    assert run.log == []


class Deaf(LossyBus):
    """A bus on which the heartbeats of drives, and their answers to guarding, may be lost."""

    deaf = False

    def _answer(self, arbitration_id: int, data: bytes) -> None:
        if not (self.deaf and arbitration_id & 0x780 == 0x700):
            super()._answer(arbitration_id, data)


class Guarded(Enabled):
    """Drives that have no heartbeat."""

    def __init__(self, folder: Path) -> None:
        eds = folder / "guarded.eds"
        eds.write_text(guarded_without_heartbeat(EDS.read_text()))
        super().__init__(eds=eds, bus=Deaf)


@pytest.mark.parametrize("ever", [True, False])
def test_a_guarded_drive_that_does_not_answer_guarding_is_lost(ever: bool, tmp_path: Path) -> None:
    """Also where it never does, such as behind an adapter that sends no remote frames: no watchdog is armed."""
    run = Guarded(tmp_path)
    if ever:
        run.bus.losses["heartbeat"] = 5
        run.run(10 * CYCLES)
        assert run.log == []
    else:
        for axis in run.driver._axes:
            axis.presence = Presence(axis.drive.node_id)
            axis.use(axis.dictionary)
    run.bus.deaf = True  # type: ignore[attr-defined]
    sample = run.until_wrong(2 * CYCLES)
    assert sample.trouble == "joint 1 (node 1): no answer to node guarding; check the cable and the drive's supply"
    assert sample.missing == 0


@pytest.mark.parametrize(
    ("heard", "seen"),
    [
        (b"\x05", "heartbeats beside the answers to node guarding"),
        (b"\x7f", "a heartbeat that says pre-operational"),
    ],
)
def test_a_heartbeat_beside_guarding_is_of_a_second_node(heard: bytes, seen: str, tmp_path: Path) -> None:
    run = Guarded(tmp_path)
    run.bus.doubles["heartbeat"] = 1
    run.run(SETTLED)
    sample = _heartbeats(run, heard, 0.1, 0.01, 10 * CYCLES)
    assert sample is not None
    assert str(sample.trouble).startswith(f"joint 2 (node 2): a second node has its id: {seen} (COB-ID 702h)")


def test_a_boot_up_message_before_the_first_answer_is_of_a_reset_in_the_preparation() -> None:
    bus, log = LossyBus(RIG, EDS), list[object]()
    driver = bus.driver(lambda *line: log.append(line))
    driver.discover()
    driver.configure()
    bus._answer(0x702, b"\0")
    assert {driver.exchange(None, 0.01).trouble for _ in range(CYCLES)} == {None}
    assert log == []


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
        (0x705, "00", "the heartbeat of node 5, which is not in the rig file"),
        (0x1A5, "00", "TPDO 1 of node 37, which is not in the rig file"),
        (0x582, "00", ""),
        (0x700, "05", ""),
        (0x085, "00", ""),
    ],
)
def test_what_endangers_nothing_is_at_most_a_warning(arbitration_id: int, data: str, warned: str) -> None:
    run = Enabled()
    for _ in range(3):
        run.bus._answer(arbitration_id, bytes.fromhex(data))
        run.run(1)
    if "rig file" in warned:
        level = "info" if arbitration_id & 0x780 == 0x700 else "warning"
        assert run.log == [(level, f"{warned} (COB-ID {arbitration_id:03X}h)")]
    else:
        named = f"{warned}, sent by another master (COB-ID {arbitration_id:03X}h); disconnect it"
        assert run.log == ([("warning", named)] if warned else [])


def test_a_pdo_of_our_node_that_the_run_does_not_use_is_named_once_and_counted() -> None:
    run = Enabled()
    for _ in range(SETTLED):
        run.bus._answer(0x282, bytes(8))
        run.run(1)
    text = "TPDO 2 of joint 2 (node 2), not used in this run: not switched off, or of a second node (COB-ID 282h)"
    assert run.log == [("warning", text)]
    run.driver.close()
    count, load = [text for level, text in run.log if level == "info"]
    assert count == f"{SETTLED} times: {text}"
    assert re.fullmatch(r"load of the bus at most \d\d% in 0.05 s", load)


class Adapter(LossyBus):
    """One whose controller has a state, and tells it."""

    state = can.BusState.ACTIVE


@pytest.mark.parametrize(
    ("state", "level", "text"),
    [
        (can.BusState.PASSIVE, "warning", can_errors.ERROR_PASSIVE),
        (can.BusState.ERROR, "error", can_errors.BUS_OFF),
    ],
)
def test_the_state_of_a_controller_that_sends_no_error_frames_is_asked_for(state: Any, level: str, text: str) -> None:
    run = Enabled(bus=Adapter)
    run.run(CYCLES)
    assert run.log == []
    run.bus.state = state
    troubles = {run.exchange().trouble for _ in range(round(0.1 * RIG.rate))}
    assert run.log == [(level, text)]
    assert (can_errors.BUS_OFF in troubles) == (level == "error")


def test_our_own_frames_that_come_back_are_not_named() -> None:
    """As on udp_multicast, which does not mark them."""
    run = Enabled()
    run.driver._link._expected_echoes = deque(maxlen=100)
    run.bus.witness = run.bus._answer
    run.run(CYCLES)
    assert run.driver._link.echoes > 3 * CYCLES
    assert run.log == []
