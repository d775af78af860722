"""SDO transfers, frame by frame, with a drive that answers right, wrongly, late or not at all."""

from collections.abc import Callable

import pytest

from drivers.canopen.bus import Link
from drivers.canopen.sdo import Sdo, SdoWrite
from recordings.errors import RunFailed
from tests.drivers.canopen.scripted import Frame, ScriptedBus

Script = list[tuple[str, list[str]]]
"""Data of requests and of the answers to each."""
MODE = SdoWrite(0x6060, 0, "<b", 8)
WRITE_MODE = ("2f 60 60 00 08 00 00 00", ["60 60 60 00 00 00 00 00"])
READ_MODE, TIMEOUT = "40 60 60 00 00 00 00 00", ("80 00 00 00 00 00 04 05", [])


def sdo(script: Script, other_frames: list[Frame] | None = None) -> tuple[Sdo, ScriptedBus]:
    bus = ScriptedBus([((0x602, request), [(0x582, data) for data in answers]) for request, answers in script])
    received = [] if other_frames is None else other_frames
    client = Sdo(2, "joint 2 (node 2)", Link(bus), lambda i, data: received.append((i, data.hex(" "))))
    client._client.RESPONSE_TIMEOUT = 0.01
    return client, bus


@pytest.mark.parametrize(
    ("transfer", "script", "result"),
    [
        (lambda s: s.read(0x6041, 0, "<H"), [("40 41 60 00 00 00 00 00", ["4b 41 60 00 37 12 00 00"])], 0x1237),
        (
            lambda s: s.read_text(0x1008),
            [
                ("40 08 10 00 00 00 00 00", ["41 08 10 00 0a 00 00 00"]),
                ("60 00 00 00 00 00 00 00", ["00 73 65 72 76 6f 20 64"]),
                ("70 00 00 00 00 00 00 00", ["19 72 76 65 00 00 00 00"]),
            ],
            "servo drve",
        ),
        (
            lambda s: s.read_bytes(0x2030, 0),
            [("40 30 20 00 00 00 00 00", ["43 30 20 00 70 11 01 00"])],
            (70_000).to_bytes(4, "little"),
        ),
        (lambda s: s.write(MODE), [WRITE_MODE, (READ_MODE, ["4f 60 60 00 08 00 00 00"])], None),
        (lambda s: s.write(MODE), [WRITE_MODE, (READ_MODE, ["80 60 60 00 01 00 01 06"])], None),  # write only
        (
            lambda s: s.write(SdoWrite(0x1800, 1, "<I", 0x182, mask=0xA000_07FF)),
            [
                ("23 00 18 01 82 01 00 00", ["60 00 18 01 00 00 00 00"]),
                ("40 00 18 01 00 00 00 00", ["43 00 18 01 82 01 00 40"]),
            ],
            None,
        ),
        (lambda s: s.has(0x6060, 0), [(READ_MODE, ["4f 60 60 00 08 00 00 00"])], True),
        (lambda s: s.has(0x6060, 0), [(READ_MODE, ["80 60 60 00 01 00 01 06"])], True),  # write only
        (lambda s: s.has(0x6060, 0), [(READ_MODE, ["80 60 60 00 00 00 02 06"])], False),  # no such object
        (lambda s: s.has(0x6060, 0), [(READ_MODE, ["80 60 60 00 11 00 09 06"])], False),  # no such sub-index
        (lambda s: s.has(0x6060, 0), [(READ_MODE, ["80 60 60 00 00 00 00 08"])], False),  # a general error
        (lambda s: (s.has(0x6060, 0), s.is_sized), [(READ_MODE, ["4f 60 60 00 08 00 00 00"])], (True, True)),
        (lambda s: (s.has(0x6060, 0), s.is_sized), [(READ_MODE, ["42 60 60 00 08 00 00 00"])], (True, False)),
    ],
)
def test_transfer(transfer: Callable[[Sdo], object], script: Script, result: object) -> None:
    client, bus = sdo(script)
    assert transfer(client) == result
    bus.assert_finished()


OFF = SdoWrite(0x6040, 0, "<H", 0, check=False)
WRITE_OFF, STALE = "2b 40 60 00 00 00 00 00", "60 40 60 00 00 00 00 00"


@pytest.mark.parametrize(
    ("transfer", "script", "reason"),
    [
        (
            lambda s: s.write(MODE),
            [WRITE_MODE, (READ_MODE, ["4f 60 60 00 07 00 00 00"])],
            "6060:00 was written 0x8 and reads back 0x7",
        ),
        (
            lambda s: s.read(0x2200, 1, "<h"),
            [("40 00 22 01 00 00 00 00", ["80 00 22 01 00 00 02 06"])],
            r"joint 2 \(node 2\) refuses to read object 2200:01: .*does not exist",
        ),
        # Some drives omit the address in an abort.
        (
            lambda s: s.read(0x2200, 1, "<h"),
            [("40 00 22 01 00 00 00 00", ["80 00 00 00 00 00 02 06"])],
            "does not exist",
        ),
        (
            lambda s: s.read(0x6041, 0, "<H"),
            [("40 41 60 00 00 00 00 00", []), TIMEOUT],
            "does not answer .*check its",
        ),
        # A response to another request does not confirm that the drive was switched off.
        (lambda s: s.write(OFF), [(WRITE_OFF, ["60 16 10 01 00 00 00 00"]), TIMEOUT], "does not answer"),
        (lambda s: s.write(OFF), [(WRITE_OFF, ["80 16 10 01 00 00 02 06"]), TIMEOUT], "does not answer"),
    ],
)
def test_failed_transfer_names_drive_object_and_reason(
    transfer: Callable[[Sdo], object], script: Script, reason: str
) -> None:
    client, bus = sdo(script)
    with pytest.raises(RunFailed, match=reason):
        transfer(client)
    bus.assert_finished()


def test_repeated_acknowledgement_does_not_confirm_a_command_that_was_lost() -> None:
    client, bus = sdo([(WRITE_OFF, []), TIMEOUT])
    bus.receive_first((0x582, STALE))
    with pytest.raises(RunFailed, match="does not answer"):
        client.write(OFF)


def test_other_frames_are_passed_on() -> None:
    other_frames: list[Frame] = []
    client, bus = sdo([("40 41 60 00 00 00 00 00", ["40", "4b 41 60 00 40 02 00 00"])], other_frames)
    bus.receive_first((0x701, "05"))
    assert client.read(0x6041, 0, "<H") == 0x240
    assert other_frames == [(0x701, "05"), (0x582, "40")]
