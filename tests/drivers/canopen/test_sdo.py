import pytest

from drivers.canopen.bus import Link
from drivers.canopen.sdo import Sdo
from recordings.errors import RunFailed
from tests.drivers.canopen.scripted import Frame, ScriptedBus


def sdo(script: list[tuple[Frame, list[Frame]]], other_frames: list[Frame] | None = None) -> tuple[Sdo, ScriptedBus]:
    bus = ScriptedBus(script)
    received = [] if other_frames is None else other_frames
    link = Link(bus)
    return Sdo(2, "joint 2 (node 2)", link, lambda i, data: received.append((i, data.hex(" ")))), bus


def test_read_expedited() -> None:
    client, bus = sdo([((0x602, "40 41 60 00 00 00 00 00"), [(0x582, "4b 41 60 00 37 12 00 00")])])
    assert client.read(0x6041, 0, "<H") == 0x1237
    bus.assert_finished()


def test_read_text_in_segments() -> None:
    client, bus = sdo(
        [
            ((0x602, "40 08 10 00 00 00 00 00"), [(0x582, "41 08 10 00 0a 00 00 00")]),
            ((0x602, "60 00 00 00 00 00 00 00"), [(0x582, "00 73 65 72 76 6f 20 64")]),
            ((0x602, "70 00 00 00 00 00 00 00"), [(0x582, "19 72 76 65 00 00 00 00")]),
        ]
    )
    assert client.read_text(0x1008) == "servo drve"
    bus.assert_finished()


def test_write_is_read_back() -> None:
    client, bus = sdo(
        [
            ((0x602, "2f 60 60 00 08 00 00 00"), [(0x582, "60 60 60 00 00 00 00 00")]),
            ((0x602, "40 60 60 00 00 00 00 00"), [(0x582, "4f 60 60 00 08 00 00 00")]),
        ]
    )
    client.write(0x6060, 0, "<b", 8)
    bus.assert_finished()


def test_different_value_read_back_is_an_error() -> None:
    client, _ = sdo(
        [
            ((0x602, "2f 60 60 00 08 00 00 00"), [(0x582, "60 60 60 00 00 00 00 00")]),
            ((0x602, "40 60 60 00 00 00 00 00"), [(0x582, "4f 60 60 00 07 00 00 00")]),
        ]
    )
    with pytest.raises(RunFailed, match="6060:00 was written 0x8 and reads back 0x7"):
        client.write(0x6060, 0, "<b", 8)


def test_abort_names_drive_and_object() -> None:
    client, _ = sdo([((0x602, "40 00 22 01 00 00 00 00"), [(0x582, "80 00 22 01 00 00 02 06")])])
    with pytest.raises(RunFailed, match=r"joint 2 \(node 2\) refuses to read object 2200:01: .*does not exist"):
        client.read(0x2200, 1, "<h")


def test_timeout_error_says_what_to_check() -> None:
    client, _ = sdo([((0x602, "40 41 60 00 00 00 00 00"), []), ((0x602, "80 00 00 00 00 00 04 05"), [])])
    client._client.RESPONSE_TIMEOUT = 0.01
    with pytest.raises(RunFailed, match=r"does not answer .*check its power"):
        client.read(0x6041, 0, "<H")


def test_other_frames_are_passed_on() -> None:
    other_frames: list[Frame] = []
    client, _ = sdo(
        [
            (
                (0x602, "40 41 60 00 00 00 00 00"),
                [(0x701, "05"), (0x582, "40"), (0x582, "4b 41 60 00 40 02 00 00")],
            )
        ],
        other_frames,
    )
    assert client.read(0x6041, 0, "<H") == 0x240
    assert other_frames == [(0x701, "05"), (0x582, "40")]


@pytest.mark.parametrize(
    ("before", "stale"),
    [
        (True, (0x582, "60 40 60 00 00 00 00 00")),
        (False, (0x582, "60 16 10 01 00 00 00 00")),
        (False, (0x582, "80 16 10 01 00 00 02 06")),
    ],
)
def test_response_to_another_request_is_not_a_confirmation(before: bool, stale: Frame) -> None:
    """A repeated acknowledgement while the command is lost: the drive was not switched off."""
    client, bus = sdo(
        [
            ((0x602, "2b 40 60 00 00 00 00 00"), [] if before else [stale]),
            ((0x602, "80 00 00 00 00 00 04 05"), []),
        ]
    )
    client._client.RESPONSE_TIMEOUT = 0.01
    if before:
        bus.receive_first(stale)
    with pytest.raises(RunFailed, match="does not answer"):
        client.write(0x6040, 0, "<H", 0, check=False)


def test_abort_without_an_address_is_accepted() -> None:
    client, _ = sdo([((0x602, "40 00 22 01 00 00 00 00"), [(0x582, "80 00 00 00 00 00 02 06")])])
    with pytest.raises(RunFailed, match="does not exist"):
        client.read(0x2200, 1, "<h")


@pytest.mark.parametrize(
    ("answer", "exists"),
    [
        ("4f 60 60 00 08 00 00 00", True),
        ("80 60 60 00 01 00 01 06", True),  # write only
        ("80 60 60 00 00 00 02 06", False),  # no such object
        ("80 60 60 00 11 00 09 06", False),  # no such sub-index
    ],
)
def test_object_that_cannot_be_read_is_not_a_missing_one(answer: str, exists: bool) -> None:
    client, _ = sdo([((0x602, "40 60 60 00 00 00 00 00"), [(0x582, answer)])])
    assert client.has(0x6060, 0) is exists


def test_write_only_object_is_not_read_back() -> None:
    client, bus = sdo(
        [
            ((0x602, "2f 60 60 00 08 00 00 00"), [(0x582, "60 60 60 00 00 00 00 00")]),
            ((0x602, "40 60 60 00 00 00 00 00"), [(0x582, "80 60 60 00 01 00 01 06")]),
        ]
    )
    client.write(0x6060, 0, "<b", 8)
    bus.assert_finished()


def test_bits_outside_the_mask_are_not_compared() -> None:
    client, bus = sdo(
        [
            ((0x602, "23 00 18 01 82 01 00 00"), [(0x582, "60 00 18 01 00 00 00 00")]),
            ((0x602, "40 00 18 01 00 00 00 00"), [(0x582, "43 00 18 01 82 01 00 40")]),
        ]
    )
    client.write(0x1800, 1, "<I", 0x182, mask=0xA000_07FF)
    bus.assert_finished()


def test_object_of_any_size_is_read() -> None:
    client, _ = sdo([((0x602, "40 30 20 00 00 00 00 00"), [(0x582, "43 30 20 00 70 11 01 00")])])
    assert client.read_bytes(0x2030, 0) == (70_000).to_bytes(4, "little")
