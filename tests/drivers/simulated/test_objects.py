"""Answers of a simulated drive to SDO requests: abort codes as in CiA 301."""

import struct
from pathlib import Path

import pytest

from drivers.simulated.drive import SimulatedCanopenDrive
from drivers.simulated.habits import Habits
from recordings.config import validated
from recordings.rig import Drive
from tests.drivers.simulated.dictionaries import U8, U32, Item, MadeUpDrive, base, eds

NODE = 4


class SdoClient:
    """Sends SDO requests to a drive and returns the value, or the abort code as a negative number."""

    def __init__(self, folder: Path, made_up: MadeUpDrive) -> None:
        path = folder / "drive.eds"
        path.write_text(eds(made_up.items))
        self.sent: list[tuple[int, bytes]] = []
        self.drive = SimulatedCanopenDrive(
            Drive(node_id=NODE),
            2e-4,
            lambda arbitration_id, data: self.sent.append((arbitration_id, data)),
            lambda: 0.0,
            lockstep=True,
            eds=path,
            habits=validated(dict(made_up.habits), Habits, "test"),
        )

    def request(self, data: bytes) -> int:
        self.sent.clear()
        self.drive.receive(0x600 + NODE, data.ljust(8, b"\0"), 0.0)
        ((arbitration_id, answer),) = self.sent
        assert arbitration_id == 0x580 + NODE
        (value,) = struct.unpack_from("<I", answer, 4)
        return -value if answer[0] == 0x80 else value

    def read(self, index: int, sub: int = 0) -> int:
        return self.request(struct.pack("<BHB", 0x40, index, sub))

    def write(self, index: int, sub: int, layout: str, value: int) -> int:
        data = struct.pack(f"<{layout}", value)
        return self.request(struct.pack("<BHB", 0x23 | 4 - len(data) << 2, index, sub) + data)


@pytest.fixture
def client(tmp_path: Path) -> SdoClient:
    items = base() | {(0x1024, 0): Item(U8, "wo"), (0x2005, 0): Item(U32, default=None)}
    habits = {"allowed": {"605A": [6]}, "refuse_write": ["1006"], "refuse_read": ["1008"], "values": {"6066": 33}}
    return SdoClient(tmp_path, MadeUpDrive(items, habits))


def test_reads_are_answered_or_aborted(client: SdoClient) -> None:
    assert client.read(0x6085) == 100_000
    assert client.read(0x6066) == 33
    assert client.read(0x2005) == 0
    assert client.read(0x5000) == -0x06020000
    assert client.read(0x6085, 1) == -0x06090011
    assert client.read(0x60C2, 9) == -0x06090011
    assert client.read(0x1024) == -0x06010001
    assert client.read(0x1008) == -0x08000020


def test_writes_are_taken_or_aborted(client: SdoClient) -> None:
    assert client.write(0x6085, 0, "I", 5) == 0
    assert client.read(0x6085) == 5
    assert client.write(0x1024, 0, "B", 5) == 0
    assert client.write(0x6041, 0, "H", 5) == -0x06010002
    assert client.write(0x6085, 0, "H", 5) == -0x06070010
    assert client.write(0x6007, 0, "h", 4) == -0x06090031
    assert client.write(0x6007, 0, "h", -1) == -0x06090032
    assert client.write(0x605A, 0, "h", 2) == -0x06090030
    assert client.write(0x605A, 0, "h", 6) == 0
    assert client.write(0x1006, 0, "I", 2000) == -0x08000020
    assert client.write(0x5000, 0, "I", 2000) == -0x06020000
    assert client.write(0x6085, 3, "I", 2000) == -0x06090011


def test_modes_that_are_not_supported_are_refused(client: SdoClient) -> None:
    assert client.write(0x6060, 0, "b", 8) == 0
    assert client.read(0x6061) == 8
    assert client.write(0x6060, 0, "b", 1) == -0x06090030


def test_reset_communication_restores_only_its_objects(client: SdoClient) -> None:
    client.write(0x1017, 0, "H", 100)
    client.write(0x6085, 0, "I", 5)
    client.drive.receive(0x000, bytes([0x82, NODE]), 0.0)
    assert (client.read(0x1017), client.read(0x6085)) == (0, 5)
    client.drive.receive(0x000, bytes([0x81, NODE]), 0.0)
    assert client.read(0x6085) == 100_000


def test_every_simulated_drive_says_that_it_is_simulated(client: SdoClient) -> None:
    assert client.read(0x5FFF, 1) == 1
    assert client.read(0x5FFF, 3) == len("delta-workbench simulated drive")  # the length of a segmented transfer
