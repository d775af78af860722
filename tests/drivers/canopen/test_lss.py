"""LSS, frame by frame: a device gets its node id and bit rate, alone or by its identity; none is left waiting."""

import pytest

from drivers.canopen.bus import Link
from drivers.canopen.lss import Identification, configure
from recordings.errors import BadInput, RunFailed
from tests.drivers.canopen.scripted import Frame, ScriptedBus

DEVICE = (0xAB, 0xCD, 0x10001, 1234)
NUMBERS = ("ab 00 00 00", "cd 00 00 00", "01 00 01 00", "d2 04 00 00")
Script = list[tuple[Frame, list[Frame]]]


def exchange(request: str, *answers: str) -> tuple[Frame, list[Frame]]:
    """A request of the master and the answers of devices, filled up with zeros."""
    return (0x7E5, _filled(request)), [(0x7E4, _filled(answer)) for answer in answers]


def _filled(data: str) -> str:
    return data + " 00" * (8 - len(data.split()))


ALONE, WAIT = exchange("04 01"), exchange("04 00")
"""All devices get ready for configuration; all wait for nothing."""
ASKED = [exchange(f"{0x5A + k:02x}", f"{0x5A + k:02x} {number}") for k, number in enumerate(NUMBERS)]
CALLED = [exchange(f"{0x40 + k:02x} {number}") for k, number in enumerate(NUMBERS[:3])]
NODE, STORED = exchange("11 05", "11"), exchange("17", "17")


@pytest.mark.parametrize(
    ("device", "found"), [(None, [ALONE, *ASKED]), (DEVICE, [*CALLED, exchange(f"43 {NUMBERS[3]}", "44")])]
)
def test_a_device_gets_its_node_id_and_bit_rate(device: Identification | None, found: Script) -> None:
    bus = ScriptedBus([*found, NODE, exchange("13 00 02", "13"), STORED, WAIT])
    assert configure(Link(bus), device, 5, 500_000) == DEVICE
    bus.assert_finished()


@pytest.mark.parametrize(
    ("device", "script", "words"),
    [
        (None, [ALONE, exchange("5a")], "none found"),
        (None, [ALONE, exchange("5a", "5a ab", "5a ab")], "several found"),
        (DEVICE, [*CALLED, exchange(f"43 {NUMBERS[3]}")], "no device with this identity"),
        (None, [ALONE, *ASKED, exchange("11 05", "11 01")], "refuses: node id, LSS error 1"),
        (None, [ALONE, *ASKED, NODE, exchange("17")], r"does not answer \(storing\)"),
    ],
)
def test_what_goes_wrong_is_named_and_nobody_is_left_waiting(
    device: Identification | None, script: Script, words: str
) -> None:
    bus = ScriptedBus([*script, WAIT])
    with pytest.raises(RunFailed, match=words):
        configure(Link(bus), device, 5, None)
    bus.assert_finished()


def test_a_bit_rate_that_lss_does_not_have_is_refused() -> None:
    with pytest.raises(BadInput, match="1000000"):
        configure(Link(ScriptedBus([])), None, 5, 300_000)
