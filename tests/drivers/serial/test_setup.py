"""Discovery and configuration of serial drives by (command, reply) pairs, with three drives on one line."""

import pytest

from drivers.serial.drive import SIMULATED_LOCKSTEP
from recordings.buses import SerialBus, SerialRegisters
from recordings.drives import PROTECTIONS
from recordings.errors import BadInput, RunFailed
from recordings.rig import Rig
from tests.drivers.serial.script import ENDS, FAULT, FLUSH, OFF, RIG, SET_UP, configured, drives, off, status
from tests.drivers.serial.scripted_port import Exchange

Accepts = tuple[str, ...]


def accepting(names: Accepts, bus: SerialBus = RIG.serial) -> Rig:
    """The rig whose drives are driven without these protections."""
    drives = tuple(drive.model_copy(update={"accept_missing": names}) for drive in RIG.drives)
    return RIG.model_copy(update={"bus": bus, "drives": drives})


def found(node: int) -> list[Exchange]:
    """A drive says its name and where it stands."""
    return [(f"{node} g f0x80", "v A"), (f"{node} g r0x32", "v 0")]


def test_discover_returns_the_identities() -> None:
    stands = [(f"{node} g r0x32", "v 4096") for node in (1, 3)]
    lockstep = ("2 g f0x80", f"v {SIMULATED_LOCKSTEP}")
    script = [FLUSH, ("1 g f0x80", "v XTL-230"), stands[0], lockstep, ("2 g r0x32", "v -500"), ("3 g f0x80", "v 12")]
    script.append(stands[1])
    amplifiers, _, _ = drives(script)
    identities = amplifiers.discover()
    assert [identity.device for identity in identities] == ["XTL-230", SIMULATED_LOCKSTEP, "12"]
    assert [identity.simulated for identity in identities] == [False, True, False]
    assert [identity.lockstep for identity in identities] == [False, True, False]
    assert [identity.position for identity in identities] == [
        RIG.drives[0].to_position(4096),
        1.0,
        RIG.drives[2].to_position(4096),
    ]
    assert identities[1].address == "'2' on line"


@pytest.mark.parametrize(
    ("replies", "reason"),
    [
        ([""] * 3, "no reply in time"),
        (["e 9"], r"the drive refuses '2 g f0x80': unknown register \(e 9\)"),
    ],
)
def test_only_drives_without_a_name_are_named(replies: list[str], reason: str) -> None:
    unnamed = [("2 g f0x80", reply) for reply in replies]
    amplifiers, _, _ = drives([FLUSH, *found(1), *unnamed, *found(3)])
    with pytest.raises(RunFailed, match=rf"^joint 2 \('2' on line\): {reason}\. Check supply, cable, baud"):
        amplifiers.discover()


def test_command_is_repeated_after_a_disturbed_reply_and_settings_are_written_and_read_back() -> None:
    script = [FLUSH, ("1 g f0x80", b"\x80\r"), *found(1), *found(2), *found(3)]
    amplifiers, port, _ = drives([*script, *SET_UP])
    amplifiers.discover()
    amplifiers.configure()
    port.assert_finished()


@pytest.mark.parametrize(
    ("script", "reason"),
    [
        (
            [*configured(1, *ENDS[1])[:4], ("1 g r0xba", "v 49")],
            r"r0xba \(following error.*reads back as 49, 50 was written",
        ),
        (
            [*configured(1, *ENDS[1])[:3], ("1 s r0xba 50", "e 9")],
            r"refuses '1 s r0xba 50': unknown register \(e 9\)",
        ),
        # Faults that are latched are cleared; one that stays is named.
        (
            [off(1), ("1 g r0xa4", "v 528"), ("1 s r0xa4 528", "ok"), ("1 g r0xa4", "v 16")],
            r"motor too hot \(0x0010\), cannot be reset",
        ),
    ],
)
def test_drive_that_cannot_be_set_up_is_refused(script: list[Exchange], reason: str) -> None:
    amplifiers, port, _ = drives(script)
    with pytest.raises(RunFailed, match=f"joint 1 .*{reason}"):
        amplifiers.configure()
    port.assert_finished()


def test_watchdog_of_the_rig_file_is_armed_and_switched_off_at_the_end() -> None:
    bus = SerialBus(ports=("line",), registers=SerialRegisters(watchdog="r0xf0"), watchdog_timeout=0.2)
    script: list[Exchange] = []
    for node, ends in ENDS.items():
        armed: list[Exchange] = [(f"{node} s r0xf0 200", "ok"), (f"{node} g r0xf0", "v 200")]
        script += [*configured(node, *ends), *armed, status(node, OFF)]
    script += [pair for node in (1, 2, 3) for pair in (off(node), (f"{node} s r0xf0 0", "ok"))]
    amplifiers, port, log = drives(script, accepting((), bus))
    amplifiers.configure()
    amplifiers.close()
    port.assert_finished()
    assert log == []


NAMED = ("following error", "position limits", "quick stop ramp")
BARE = SerialBus(
    ports=("line",),
    registers=SerialRegisters(following_error="", upper_limit="", lower_limit="", deceleration=""),
)
"""Drives that protect nothing."""


@pytest.mark.parametrize(
    ("bus", "accepted", "reason"),
    [
        (RIG.serial, (), r'watchdog missing: .*powered; name watchdog in \[bus.*accept_missing = \["watchdog"\]'),
        (BARE, ("watchdog", *NAMED[1:]), r"following error missing: .*name following_error in"),
        (BARE, ("watchdog", NAMED[0], NAMED[2]), r"position limits missing: .*name upper_limit and lower_limit in"),
        (BARE, ("watchdog", *NAMED[:2]), r"quick stop ramp missing: .*name deceleration in"),
    ],
)
def test_missing_protection_is_a_problem_and_refused_before_anything_is_written(
    bus: SerialBus, accepted: Accepts, reason: str
) -> None:
    amplifiers, port, _ = drives([], accepting(accepted, bus))
    with pytest.raises(BadInput, match=rf"^joint 1 \('1' on line\): {reason}"):
        amplifiers.configure()
    amplifiers.close()
    assert port.sent == []


def test_one_position_limit_alone_protects_one_side_only() -> None:
    bus = SerialBus(ports=("line",), registers=SerialRegisters(lower_limit=""))
    with pytest.raises(BadInput, match="position limits missing"):
        drives([], accepting(("watchdog",), bus))[0].configure()


def test_accepted_protections_are_warned_of_and_every_one_is_shown() -> None:
    cleared = [exchange for node in (1, 2, 3) for exchange in bare(node)]
    states = [exchange for node in (1, 2, 3) for exchange in (status(node, OFF), (f"{node} g r0xc8", "v 0"))]
    amplifiers, port, log = drives([*cleared, *states], accepting(("watchdog", *NAMED), BARE))
    amplifiers.configure()
    assert [(level, text.partition(" missing")[0]) for level, _, text in log] == [
        ("warning", name) for name in ("watchdog", *NAMED)
    ]
    assert log[0][1] == "joint 1 ('1' on line), joint 2 ('2' on line), joint 3 ('3' on line)"
    assert log[0][2].endswith("the joint stays powered; the rig file accepts it")
    shown = {row.what: (row.found, row.verdict) for row in amplifiers.check() if row.what in PROTECTIONS}
    assert {verdict for _, verdict in shown.values()} == {"accepted"}
    port.assert_finished()


def bare(node: int) -> list[Exchange]:
    """Set-up of a drive without limits."""
    return [
        off(node),
        *[(f"{node} g r0xa4", "v 0")] * 2,
        (f"{node} s r0xc8 0", "ok"),
        (f"{node} g r0xc8", "v 0"),
        status(node, OFF),
    ]


def test_check_compares_and_writes_nothing() -> None:
    actual = {"r0xba": 50, "r0xcf": 7, "r0xb8": 1400, "r0xb9": -1200, "r0xc8": 256}
    script: list[Exchange] = []
    for node in (1, 2, 3):
        faulty = [status(1, FAULT), ("1 g r0xa4", "v 4")] if node == 1 else [status(node, OFF)]
        script += [*faulty, *((f"{node} g {name}", f"v {value}") for name, value in actual.items())]
    amplifiers, port, _ = drives(script)
    results = amplifiers.check()
    port.assert_finished()
    shown = [(f.found, f.verdict) for f in results if f.where.startswith("joint 2") and f.what in PROTECTIONS]
    assert shown[0] == ("missing: with this program killed or the cable pulled, the joint stays powered", "accepted")
    assert shown[1:] == [("by r0xba", "noted"), ("by r0xb8, r0xb9", "noted"), ("by r0xcf", "noted")]
    noteworthy = [(f.where[:7], f.what[:5], f.expected, f.found) for f in results if f.verdict == "will be written"]
    assert noteworthy[0] == ("joint 1", "state", "off", "fault: short circuit (0x0004)")
    assert ("joint 1", "r0xcf", "15000", "7") in noteworthy
    assert ("joint 2", "r0xb8", "1700", "1400") in noteworthy
    assert not amplifiers.close()
    assert port.sent == [command for command, _ in script]
