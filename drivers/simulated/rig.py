"""The simulated rig: three simulated drives around one machine, on a real CAN bus interface.

Two paces. Lockstep: each SYNC advances simulated time by one period, as fast as the computer can; the same seed gives
the same frames in the same order. Real time: the machine follows the host's clock.
"""

import time
from functools import partial

import can

from drivers.canopen.bus import Link
from drivers.canopen.setup import SYNC_ID
from drivers.simulated.config import SimConfig
from drivers.simulated.drive import SimulatedCanopenDrive
from drivers.simulated.service import CHUNK, Service, advance_machine
from recordings.recording import Pace
from recordings.rig import Rig


class SimulatedRig(Service):
    """Three CiA 402 drives around one machine on one CAN bus."""

    def __init__(self, rig: Rig, config: SimConfig, bus: can.BusABC, *, pace: Pace, seed: int) -> None:
        super().__init__(rig, config, pace, seed)
        self._link = Link(bus)
        self._outbox: list[tuple[int, bytes]] = []
        self.drives = [
            SimulatedCanopenDrive(
                drive, self.machine.dt, self._send, partial(self._measure_voltage, j), lockstep=self._lockstep
            )
            for j, drive in enumerate(rig.drives)
        ]
        self._last_sync: float | None = None
        self._update()

    # Life cycle

    def leave(self) -> None:
        """See `Service`."""
        self._link.close()

    def run(self) -> None:
        """See `Service`."""
        self._flush()
        self._start_clock()
        while not self._stopping.is_set():
            frame = self._link.receive(0.05 if self._lockstep else CHUNK)
            if frame is not None:
                self._handle(*frame)
            elif not self._lockstep:
                self._catch_up()

    # The bus

    def _send(self, arbitration_id: int, data: bytes) -> None:
        self._outbox.append((arbitration_id, data))

    def _flush(self) -> None:
        for arbitration_id, data in self._outbox:
            self._link.send(arbitration_id, data)
        self._outbox.clear()

    def _handle(self, arbitration_id: int, data: bytes) -> None:
        if arbitration_id == SYNC_ID:
            self._synchronise()
        else:
            for drive in self.drives:
                drive.receive(arbitration_id, data, self.machine.time)
            self._flush()

    def _synchronise(self) -> None:
        if not self._lockstep:
            self._lock_to_sync()
        machine = self.machine
        measured = zip(machine.encoder_counts(), machine.voltage_counts(), machine.torque(), strict=True)
        for drive, (counts, voltage, torque) in zip(self.drives, measured, strict=True):
            drive.synchronise(counts, voltage, torque)
        self._flush()
        if self._lockstep:
            # Events before the next SYNC are sent with the next answer, so that the order of frames does not depend
            # on thread scheduling.
            self._advance(self._period)

    def _measure_voltage(self, joint: int) -> int:
        return self.machine.voltage_counts()[joint]

    # Simulated time

    def _catch_up(self) -> None:
        """Real time: advance the machine to the host's time, but not beyond the next expected SYNC."""
        now = self._now()
        if self._last_sync is not None and now < self._last_sync + 1.5 * self._period:
            now = min(now, self._last_sync + self._period)
        self._advance(now - self.machine.time)
        self._flush()

    def _now(self) -> float:
        """Real time: simulated time that it should be by the host's clock [s]."""
        host = time.perf_counter()
        if self._is_delayed(host):
            self._last_sync = None
        return host - self._clock_zero

    def _lock_to_sync(self) -> None:
        """Real time: advance the machine to SYNC. Real drives sample with microseconds of jitter, by a phase-locked
        loop. This thread has much more, so the machine's time follows the SYNC count where SYNC is regular."""
        now = self._now()
        if self._last_sync is not None:
            periods = round((now - self._last_sync) / self._period)
            expected = self._last_sync + periods * self._period
            if periods >= 1 and abs(now - expected) < 0.25 * self._period:
                now = expected
        self._advance(now - self.machine.time)
        self._last_sync = self.machine.time
        self._flush()

    def _advance(self, duration: float) -> None:
        if advance_machine(self.machine, self.drives, duration):
            self._update()

    def _update(self) -> None:
        for drive, count in zip(self.drives, self.machine.encoder_counts(), strict=True):
            drive.update(count, self.machine.time)
