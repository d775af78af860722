"""The end of a run: what is written to each drive, also where another does not answer."""

from collections import Counter
from types import SimpleNamespace
from typing import Any

import pytest

from drivers.canopen import preparation, shutdown
from drivers.cia402 import Controlword
from recordings.errors import RunFailed

OFF, QUICK_STOP = int(Controlword.DISABLE_VOLTAGE), int(Controlword.QUICK_STOP)


class Axis:
    """Axis of which only the SDO writes count; a silent one answers none."""

    def __init__(self, name: str, silent: bool = False, torque_offset: bool = False) -> None:
        self.name, self._silent = name, silent
        self.drive = SimpleNamespace(torque_offset=torque_offset)
        self.dictionary = SimpleNamespace()
        self.sdo = self
        self.warnings: Counter[int] = Counter()
        self.written: list[tuple[int, Any]] = []

    def write(self, index: int, sub: int, layout: str, value: int, check: bool) -> None:
        if self._silent:
            raise RunFailed("no answer")
        self.written.append((index, int(value)))

    def apply(self, write: str) -> None:
        self.written.append((0, write))

    def text_of(self, code: int) -> str:
        return "temperature"


@pytest.fixture
def axes(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Three axes, of which the second does not answer and the third has had a torque offset."""
    monkeypatch.setattr(
        preparation, "command_by_sdo", lambda axis, command: axis.write(0x6040, 0, "<H", command, check=False)
    )
    monkeypatch.setattr("drivers.canopen.setup.watchdog_off", lambda dictionary: ["no watchdog"])
    return [Axis("joint 1"), Axis("joint 2", silent=True), Axis("joint 3", torque_offset=True)]


def test_every_drive_that_answers_is_stopped_then_off_and_the_silent_one_named(axes: list[Any]) -> None:
    reports: list[tuple[str, str, str]] = []
    shutdown.power_off(axes, lambda *line: reports.append(line))
    assert axes[0].written == [(0x6040, QUICK_STOP), (0x6040, OFF)]
    assert axes[2].written == [(0x60B2, 0), (0x6040, QUICK_STOP), (0x60B2, 0), (0x6040, OFF)]
    assert reports == [("error", "joint 2", "while switching power off: no answer")] * 2


def test_released_drives_are_off_and_expect_no_master(axes: list[Any]) -> None:
    reports: list[tuple[str, str, str]] = []
    shutdown.release(axes, lambda *line: reports.append(line))
    assert axes[0].written == [(0x6040, OFF), (0, "no watchdog")]
    assert axes[2].written == [(0x6040, OFF), (0x60B2, 0), (0, "no watchdog")]
    assert reports == [("error", "joint 2", "while closing: no answer")]


def test_only_warnings_that_came_again_are_reported(axes: list[Any]) -> None:
    reports: list[tuple[str, str, str]] = []
    axes[0].warnings.update({0x4210: 3, 0x3210: 1})
    shutdown.report_repeated_warnings(axes, lambda *line: reports.append(line))
    assert reports == [("info", "joint 1", "EMCY 0x4210 (temperature) came 3 times")]
