"""Preparation of one drive: mode, faults, power, and the order of the steps."""

import re
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest

from drivers.canopen import axis, preparation
from drivers.canopen.preparation import said_once
from drivers.simulated.drive_state_machine import PowerState
from recordings.errors import BadInput, RunFailed
from tests.drivers.canopen.lossy_bus import LossyBus
from tests.drivers.canopen.made_up_runs import bus_of, rig_of
from tests.drivers.simulated.dictionaries import MADE_UP, TORQUE, U16, U32, Item, MadeUpDrive, base

WIDE = MADE_UP["wide_voltage"]


class Bench:
    """One simulated drive, the driver, and what it reports and sends."""

    def __init__(self, habits: dict[str, Any] | None = None, **keys: Any) -> None:
        made_up = MadeUpDrive(WIDE.items, {**WIDE.habits, **(habits or {})})
        rig = rig_of(made_up, **keys)
        self.bus: LossyBus = bus_of(made_up, rig)
        self.reports: list[tuple[str, str]] = []
        self.sent: list[str] = []
        self.driver = self.bus.driver(lambda level, source, text: self.reports.append((level, text)))
        self.driver._link.tap = self._note

    def _note(self, _: int, message: Any, sent: bool) -> None:
        if sent:
            self.sent.append(f"{message.arbitration_id:03X} {bytes(message.data).hex(' ')}")

    def configure(self, before: Callable[[Any], object] = lambda drive: None) -> None:
        with pytest.MonkeyPatch.context() as patch:
            for module in (axis, preparation):
                patch.setattr(module, "time", self.bus)
            self.driver.discover()
            before(self.bus.drives[0])
            self.driver.configure()

    def controlwords(self) -> list[str]:
        """Controlwords written by SDO, and NMT commands, in their order."""
        commands = [text for text in self.sent if text.startswith(("601 2b 40 60", "000 "))]
        return [text[16:21] if text.startswith("601") else text for text in commands]


def test_mode_that_the_drive_shows_must_be_the_one_written_or_none_before_power() -> None:
    with pytest.raises(RunFailed, match=r"mode 8 was written, the drive shows mode 1 \(6061h\)"):
        Bench().configure(lambda drive: drive._objects.measured.update({(0x6061, 0): lambda: 1}))
    bench = Bench()
    bench.configure(lambda drive: drive._objects.measured.update({(0x6061, 0): lambda: 0}))
    assert bench.reports == [("warning", "shows no mode yet (6061h) after mode 8 was written")]


def test_what_is_true_of_several_drives_is_said_once() -> None:
    said: list[tuple[str, str, str]] = []
    with said_once(lambda *line: said.append(line)) as report:
        for joint in ("joint 1", "joint 2"):
            report("warning", joint, "shows no mode yet")
            report("info", joint, f"reset of {joint}")
    assert said == [
        ("warning", "joint 1, joint 2", "shows no mode yet"),
        ("info", "joint 1", "reset of joint 1"),
        ("info", "joint 2", "reset of joint 2"),
    ]


def test_a_drive_that_does_not_tell_its_revision_has_none() -> None:
    assert Bench({"refuse_read": ["1018:03"]}).driver.discover()[0].revision is None


def test_fault_reset_is_one_rising_edge() -> None:
    bench = Bench({"fault_at_power_on": 0x3220, "fault_reset": 0.05})
    bench.configure()
    assert bench.controlwords() == ["000 80 01", "00 00", "80 00", "00 00", "000 01 01"]
    assert ("info", "fault 0x3220 (DC link under-voltage): reset by the controlword") in bench.reports


def test_ignored_fault_reset_is_tried_with_reset_communication() -> None:
    def lose_master(drive: Any) -> None:
        drive.fail(0x8130)
        drive._motion.reset_blocked = True

    bench = Bench({"reset_after_heartbeat_loss": False}, fault_reset_timeout=0.05)
    bench.configure(lose_master)
    reset = ["00 00", "80 00", "00 00"]
    assert bench.controlwords() == ["000 80 01", *reset, "000 82 01", *reset, "000 01 01"]
    (text,) = [text for level, text in bench.reports if level == "info" and "reset by" in text]
    assert text.startswith(
        'fault 0x8130 (master heartbeat lost): reset by NMT "reset communication" and the controlword'
    )


def test_fault_that_stays_is_named_with_what_was_tried() -> None:
    bench = Bench({"fault_at_power_on": 0x3220, "fault_reset": 1e6}, fault_reset_timeout=0.05)
    with pytest.raises(
        RunFailed, match=r"fault 0x3220 \(DC link under-voltage\) is not reset within 0.05 s.*remove its cause"
    ):
        bench.configure()


def test_drive_with_power_is_stopped_before_anything_is_written() -> None:
    def leave_enabled(drive: Any) -> None:
        drive._motion.state = PowerState.ENABLED

    bench = Bench()
    bench.configure(leave_enabled)
    assert bench.controlwords() == ["000 80 01", "02 00", "00 00", "000 01 01"]
    writes = [text for text in bench.sent if text.startswith(("601 2", "601 3"))]
    assert writes[0].startswith("601 2b 40 60 00 02 00")
    assert not bench.bus.enabled
    assert bench.reports[0][0] == "warning"


def test_drive_that_does_not_fit_is_switched_off_all_the_same() -> None:
    bench = Bench(units={"acceleration": "rpm/s"}, counts_per_turn=4096, mode="cyclic")
    bench.bus.drives[0]._objects.set(0x6502, 0, 0x25)
    bench.driver.discover()
    bench.bus.drives[0]._motion.state = PowerState.ENABLED
    with pytest.raises(BadInput, match="neither mode 7 nor 8"):
        bench.driver.configure()
    assert not bench.bus.enabled


def test_drive_whose_file_excludes_its_statusword_is_switched_off_all_the_same(tmp_path: Path) -> None:
    unmapped = {(index, sub): Item(U32) for index in (0x1A00, 0x1A01) for sub in (1, 2)}
    made_up = MadeUpDrive(base() | TORQUE | unmapped | {(0x6041, 0): Item(U16, "ro")})
    bus = bus_of(made_up, rig := rig_of(made_up, eds=str(made_up.write(tmp_path)[0])))
    driver = bus.driver(lambda *told: None)
    driver.discover()
    bus.drives[0]._motion.state = PowerState.ENABLED
    with pytest.raises(BadInput, match="6041:00 statusword: cannot be mapped"):
        driver.configure()
    assert rig.drives[0].eds
    assert not bus.enabled


@pytest.mark.parametrize(("source", "decided"), [("assumed", False), ("assumed", True), ("measured", True)])
def test_an_undecided_unit_of_position_is_for_small_motions(source: str, decided: bool) -> None:
    reports: list[str] = []
    made_up, doubt = MADE_UP["unset_factors"], '8192 by 608Fh, 1 by 6092h and 6091h: .* counts_source = "measured"'
    driver = bus_of(made_up, rig_of(made_up, counts_source=source)).driver(lambda *told: reports.append(told[2]))
    driver.discover()
    undecided = source == "assumed"
    with pytest.raises(BadInput, match=doubt) if undecided and decided else nullcontext():
        driver.configure(decided=decided)
    assert [bool(re.search(doubt, text)) for text in reports] == [True] * (undecided and not decided)
    assert decided or driver.in_doubt(1) == undecided
