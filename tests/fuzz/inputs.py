"""Generators of fuzz inputs. Each function creates `count` inputs from a seed and returns how many were refused.

Only the typed errors of the readers are caught.
"""

import struct
from collections import deque

import can
import numpy as np

from drivers.canopen.bus import Link
from drivers.canopen.drive import CanopenDrives
from drivers.protocol import Goal
from drivers.serial.protocol import InvalidReply, parse
from drivers.simulated.drive import SimulatedCanopenDrive
from recordings.rig import Drive, simulated_rig


class _FuzzBus(can.BusABC):
    """CAN bus that answers every SYNC with random frames, some of them plausible."""

    channel_info = "fuzz"

    def __init__(self, rng: np.random.Generator, per_sync: int) -> None:
        super().__init__("fuzz")
        self._is_shutdown = True
        self._rng = rng
        self._per_sync = per_sync
        self._inbox: deque[can.Message] = deque()

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        if msg.arbitration_id == 0x80:
            self._inbox.extend(frame(self._rng) for _ in range(self._per_sync))

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        return (self._inbox.popleft() if self._inbox else None), False


def frame(rng: np.random.Generator) -> can.Message:
    """Random frame, usually with an id that drives use."""
    known = int(rng.choice([0x000, 0x080, 0x180, 0x200, 0x280, 0x580, 0x600, 0x700])) + int(rng.integers(0, 5))
    extended = rng.random() < 0.05
    arbitration_id = known if rng.random() < 0.8 else int(rng.integers(0, 0x20000000 if extended else 0x800))
    return can.Message(
        arbitration_id=arbitration_id,
        data=rng.bytes(int(rng.integers(0, 9))),
        is_extended_id=extended,
        is_error_frame=rng.random() < 0.03,
        check=False,
    )


def frames_to_the_driver(count: int, seed: int) -> int:
    """Feed the driver in its cycle with all goals; return the number of exchanges with an error."""
    rng = np.random.default_rng(seed)
    per_sync = 20
    drives = CanopenDrives(simulated_rig(), Link(_FuzzBus(rng, per_sync)), lambda *line: None)
    failed_exchanges = 0
    for k in range(count // per_sync):
        drives.goal = (Goal.ENABLED, Goal.STOPPED, Goal.DISABLED)[k % 3]
        sample = drives.exchange(None, 0.0)
        failed_exchanges += sample.trouble is not None or sample.missing > 0
    return failed_exchanges


def frames_to_a_drive(count: int, seed: int) -> int:
    """Feed a simulated drive; return the number of its answers."""
    rng = np.random.default_rng(seed)
    answers = 0

    def answer(arbitration_id: int, data: bytes) -> None:
        nonlocal answers
        answers += 1

    drive = SimulatedCanopenDrive(Drive(node_id=2), 2e-4, answer, lambda: 0, lockstep=True)
    for k in range(count):
        message = frame(rng)
        drive.receive(message.arbitration_id & 0x7FF, bytes(message.data), k * 1e-3)
        if k % 50 == 0:
            # Random NMT commands usually stop the node: start it again.
            drive.receive(0x000, b"\x01\x02", k * 1e-3)
        if k % 10 == 0:
            drive.synchronise(int(rng.integers(-1000, 1000)), 0, 0.0)
            drive.update(0, k * 1e-3)
    return answers


def serial_replies(count: int, seed: int) -> int:
    """Parse lines of a serial port; return how many were refused."""
    rng = np.random.default_rng(seed)
    refused = 0
    for _ in range(count):
        line = bytearray(rng.choice([b"ok", b"v 12345", b"v -2147483648", b"e 33", b""]))
        for _ in range(int(rng.integers(0, 4))):
            line.insert(int(rng.integers(0, len(line) + 1)), int(rng.integers(0, 256)))
        if rng.random() < 0.3:
            line = bytearray(rng.bytes(int(rng.integers(0, 40))))
        try:
            parse(bytes(line))
        except InvalidReply:
            refused += 1
    return refused


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    """`data` with bytes that are flipped, cut off, inserted or zeroed, one to three times."""
    changed = bytearray(data)
    for _ in range(int(rng.integers(1, 4))):
        at = int(rng.integers(0, len(changed)))
        kind = int(rng.integers(0, 5))
        if kind == 0:
            changed[at] ^= 1 << int(rng.integers(0, 8))
        elif kind == 1:
            del changed[at:]
        elif kind == 2:
            changed[at:at] = rng.bytes(int(rng.integers(1, 50)))
        elif kind == 3:
            changed[at : at + 20] = bytes(min(20, len(changed) - at))
        else:
            changed[at : at + 8] = struct.pack("<Q", int(rng.integers(0, 2**63)))[: len(changed) - at]
        if not changed:
            return b""
    return bytes(changed)
