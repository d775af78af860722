"""A simulated CANopen drive on a bench, with manual frames and time."""

import math
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from drivers.cia402 import Controlword
from drivers.simulated.drive import SimulatedCanopenDrive
from drivers.simulated.drive_state_machine import PowerState
from drivers.simulated.habits import Habits
from drivers.simulated.mark import EDS
from drivers.simulated.troubles import Due
from recordings.config import validated
from recordings.rig import Drive
from tests.drivers.simulated.dictionaries import GEAR, INCREMENTS_PER_TURN, Address, Item, MadeUpDrive, base, pdo

NODE, DT, PERIOD = 3, 2e-4, 2e-3
VOLTS = 0.0005 * 123
"""What the drive measures [V]: 123 counts."""
INCREMENTS = INCREMENTS_PER_TURN * GEAR / math.tau
"""Encoder increments per radian of the joint."""
RPDO, TPDO = [0x6040_00_10, 0x607A_00_20], [0x6041_00_10, 0x6064_00_20]


class Bench:
    """The drive of this project, or one with other objects and habits; its motor follows unless held."""

    def __init__(
        self,
        items: Mapping[Address, Item] | None = None,
        folder: Path = Path(),
        troubles: Sequence[Due] = (),
        **habits: Any,
    ) -> None:
        self.sent: list[tuple[int, bytes]] = []
        self.now = self.torque = 0.0
        self.held_at: int | None = None
        self.drive = SimulatedCanopenDrive(
            Drive(node_id=NODE),
            DT,
            lambda arbitration_id, data: self.sent.append((arbitration_id, data)),
            lambda: VOLTS,
            lockstep=True,
            eds=EDS if items is None else MadeUpDrive(items).write(folder)[0],
            habits=validated(habits, Habits, "test"),
            troubles=troubles,
        )

    # Frames

    def nmt(self, command: int) -> None:
        self.drive.receive(0x000, bytes([command, NODE]), self.now)

    def request(self, data: bytes) -> int:
        """The value, or the abort code as a negative number, that answers an SDO request."""
        self.drive.receive(0x600 + NODE, data.ljust(8, b"\0"), self.now)
        answer = next(data for arbitration_id, data in reversed(self.sent) if arbitration_id == 0x580 + NODE)
        value = int.from_bytes(answer[4:], "little")
        return -value if answer[0] == 0x80 else value

    def read(self, index: int, sub: int = 0) -> int:
        return self.request(struct.pack("<BHB", 0x40, index, sub))

    def try_to_write(self, index: int, layout: str, value: int, sub: int = 0) -> int:
        data = struct.pack(f"<{layout}", value)
        return self.request(struct.pack("<BHB", 0x23 | 4 - len(data) << 2, index, sub) + data)

    def write(self, index: int, layout: str, value: int, sub: int = 0) -> None:
        assert self.try_to_write(index, layout, value, sub) == 0

    def command(self, controlword: int, target: int = 0) -> None:
        self.drive.receive(0x200 + NODE, struct.pack("<Hi", controlword, target), self.now)

    def sync(self) -> None:
        self.drive.synchronise(self.counts, VOLTS, self.torque, self.now)
        self.run(PERIOD)

    def cycle(self, controlword: int, target: int = 0, cycles: int = 1) -> None:
        for _ in range(cycles):
            self.command(controlword, target)
            self.sync()

    # Machine and time

    @property
    def state(self) -> PowerState:
        return self.drive.state

    @property
    def counts(self) -> int:
        """Encoder increments of the motor."""
        if self.held_at is not None:
            return self.held_at
        return round(self.drive.generator.position * self.drive.drive.counts_per_radian)

    def run(self, duration: float) -> None:
        for _ in range(round(duration / PERIOD)):
            for _ in range(round(PERIOD / DT)):
                self.drive.generator.step()
            self.now += PERIOD
            self.drive.update(self.counts, self.now)

    def start(self) -> None:
        """Follow a target every 2 ms, operational."""
        self.write(0x6060, "b", 8)
        self.try_to_write(0x60C2, "B", 2, sub=1)
        self.nmt(0x01)

    def enable(self) -> None:
        self.start()
        for word in (Controlword.SHUTDOWN, Controlword.SWITCH_ON, Controlword.ENABLE):
            self.cycle(word, self.counts)
        assert self.state is PowerState.ENABLED

    def move(self, speed: float) -> None:
        """Move at a constant speed [rad/s]."""
        step = speed * self.drive.drive.counts_per_radian * PERIOD
        for k in range(1, 51):
            self.cycle(Controlword.ENABLE, round(k * step))


def made_up(folder: Path, items: Mapping[Address, Item] | None = None, **habits: Any) -> Bench:
    """A drive with these objects and habits."""
    return Bench({**(base() if items is None else items), **pdo(0, True, RPDO, kind=1)}, folder, **habits)
