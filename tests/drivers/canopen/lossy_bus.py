"""Simulated drives on a CAN bus that loses and doubles frames on demand, in simulated time and in lockstep.

`recv` never waits, so that a timeout takes no real time. Time passes with each SYNC, by a period, and with each SDO
request; nobody else advances it but a test with `wait`.
"""

from collections import Counter, deque
from collections.abc import Callable
from pathlib import Path

import can

from drivers.canopen.bus import Link
from drivers.canopen.drive import CanopenDrives
from drivers.protocol import Goal, Power, Report
from drivers.simulated.drive import SimulatedCanopenDrive
from drivers.simulated.drive_state_machine import PowerState as DriveState
from drivers.simulated.habits import Habits
from drivers.simulated.mark import EDS
from recordings.errors import RunFailed
from recordings.rig import Rig

DT = 2.5e-3
"""Step of the drives' setpoints [s]."""
_SDO_TIME = 2e-4
"""Duration of an SDO request [s]."""
_KINDS = {
    0x000: "nmt",
    0x080: "emcy",
    0x180: "tpdo",
    0x200: "rpdo",
    0x280: "tpdo",
    0x580: "response",
    0x600: "request",
    0x700: "heartbeat",
}
_PATIENCE = 1000
"""Cycles in which drives reach a state."""
KINDS = (*sorted({*_KINDS.values()}), "sync")


def kind_of(arbitration_id: int) -> str:
    """Kind of a frame, by the predefined connection set."""
    return "sync" if arbitration_id == 0x080 else _KINDS.get(arbitration_id & 0x780, "")


def reach(driver: CanopenDrives, goal: Goal, power: Power) -> None:
    """Exchange until all drives have this power."""
    driver.goal = goal
    for _ in range(_PATIENCE):
        if {*driver.exchange(None, 0.01).power} == {power}:
            return
    raise RunFailed(f"not {goal.value}")


class LossyBus(can.BusABC):
    """The master's end; the motors follow their setpoints without delay."""

    def __init__(self, rig: Rig, eds: Path = EDS, habits: Habits | None = None) -> None:
        super().__init__("lossy")
        self._is_shutdown = True  # holds no resource that python-can would warn about
        self.now = self._moved = 0.0
        self.pulled = False
        """No frame passes."""
        self.losses: Counter[str] = Counter()
        """Number of next frames of each kind that are lost."""
        self.doubles: Counter[str] = Counter()
        """Number of next frames of each kind that are doubled."""
        self.witness: Callable[[int, bytes], None] = lambda arbitration_id, data: None
        """Called with each frame that the master sends, including lost ones."""
        self._rig, self._period = rig, 1 / rig.rate
        self._inbox: deque[tuple[int, bytes]] = deque()
        self.volts = self.torque = 0.0
        """What the drives measure [V], [N m]."""
        self.drives = [
            SimulatedCanopenDrive(
                drive,
                DT,
                self._answer,
                lambda: self.volts,
                lockstep=True,
                eds=eds,
                habits=habits or Habits(),
                axes=[other.axis for other in rig.drives if other.node_id == drive.node_id],
            )
            for drive in rig.drives
        ]

    @property
    def enabled(self) -> list[int]:
        """Numbers, from 1, of the drives that are really enabled."""
        return [i for i, drive in enumerate(self.drives, start=1) if drive.state is DriveState.ENABLED]

    # The master's end

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        arbitration_id, data = msg.arbitration_id, bytes(msg.data)
        if msg.is_remote_frame:
            for _ in range(self._copies(arbitration_id)):
                for drive in self.drives:
                    drive.receive_remote(arbitration_id, self.now)
            return
        self.witness(arbitration_id, data)
        for _ in range(self._copies(arbitration_id)):
            self.to_drives(arbitration_id, data)
        if arbitration_id == 0x080:
            self.wait(self._period)
        elif kind_of(arbitration_id) == "request":
            self.wait(_SDO_TIME)

    def recv(self, timeout: float | None = None) -> can.Message | None:
        if not self._inbox:
            return None
        arbitration_id, data = self._inbox.popleft()
        return can.Message(arbitration_id=arbitration_id, data=data, is_extended_id=False)

    def driver(self, report: Report = lambda *line: None) -> CanopenDrives:
        """The driver of the rig on this bus, in simulated time."""
        link = Link(self)
        link.clock = self.now_ns
        return CanopenDrives(self._rig, link, report)

    def now_ns(self) -> int:
        """Simulated time [ns]."""
        return round(self.now * 1e9)

    def monotonic(self) -> float:
        """Simulated time [s], for code that asks the module `time`."""
        return self.now

    # The drives' end

    def to_drives(self, arbitration_id: int, data: bytes) -> None:
        """Deliver a frame of any sender to the drives."""
        for drive in self.drives:
            if arbitration_id == 0x080:
                drive.synchronise(self._counts(drive), self.volts, self.torque)
            else:
                drive.receive(arbitration_id, data, self.now)

    def wait(self, duration: float) -> None:
        """Advance simulated time by `duration` [s]."""
        self.now += duration
        while self._moved + DT <= self.now:
            self._moved += DT
            for drive in self.drives:
                if drive.powered:
                    drive.generator.step()
                drive.update(self._counts(drive), self._moved)

    def _counts(self, drive: SimulatedCanopenDrive) -> int:
        return round((drive.generator.position - drive.drive.zero_offset) * drive.drive.counts_per_radian)

    def _answer(self, arbitration_id: int, data: bytes) -> None:
        for _ in range(self._copies(arbitration_id)):
            self._inbox.append((arbitration_id, data))

    def _copies(self, arbitration_id: int) -> int:
        kind = kind_of(arbitration_id)
        if self.pulled:
            return 0
        if self.losses[kind]:
            self.losses[kind] -= 1
            return 0
        if self.doubles[kind]:
            self.doubles[kind] -= 1
            return 2
        return 1
