"""The simulated rig: three simulated drives around one machine, on a real CAN bus interface.

Two paces. Lockstep: each SYNC advances simulated time by one period, as fast as the computer can; the same seed gives
the same frames in the same order. Real time: the machine follows the host's clock.
"""

import time
from functools import partial
from pathlib import Path

import can

from drivers.canopen.bus import Link
from drivers.simulated.config import SimConfig
from drivers.simulated.drive import SimulatedCanopenDrive
from drivers.simulated.machine import plant_step
from drivers.simulated.mark import EDS
from drivers.simulated.service import CHUNK, Service, advance_machine
from recordings.recording import Pace
from recordings.rig import Rig

_NMT, _SYNC = 0x000, 0x80
_RESETS = (b"\x81", b"\x82")
"""NMT commands: of the node, of its communication."""
_BURST = 0.05
"""Real time: longest burst of frames during which the machine does not advance [s]."""


class SimulatedRig(Service):
    """Three CiA 402 drives around one machine on one CAN bus.

    The drives have the dictionaries and habits of the sim file; the machine has their encoders and gears.
    """

    def __init__(self, rig: Rig, config: SimConfig, bus: can.BusABC, *, pace: Pace, seed: int) -> None:
        """`bus` stays open if this raises BadInput: a dictionary cannot be read."""
        self._outbox: list[tuple[int, bytes]] = []
        self._rig, self._config, self._pace = rig, config, pace
        self.drives = [self._new_drive(j) for j in range(rig.dof)]
        true = rig.model_copy(update={"drives": tuple(drive.drive for drive in self.drives)})
        super().__init__(true, config, pace, seed)
        self._link = Link(bus)
        self._link.tap = self._on_any_frame
        self._last_sync: float | None = None
        self._update()

    def _new_drive(self, joint: int) -> SimulatedCanopenDrive:
        drive, simulated = self._rig.drives[joint], self._config.drive_of_each_joint[joint]
        return SimulatedCanopenDrive(
            drive,
            plant_step(self._rig.rate),
            self._send,
            partial(self._measure_voltage, joint),
            lockstep=self._pace == "lockstep",
            eds=EDS if simulated.eds is None else Path(simulated.eds),
            habits=simulated.habits,
            axes=[other.axis for other in self._rig.drives if other.node_id == drive.node_id],
            troubles=self._config.troubles(joint + 1),
        )

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
                if not self._lockstep and frame[0] != _SYNC:
                    self._keep_up()
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

    def _on_any_frame(self, _: int, message: can.Message, sent: bool) -> None:
        """Guarding requests are remote frames, which the link does not return."""
        if message.is_remote_frame and not sent:
            for drive in self.drives:
                drive.receive_remote(message.arbitration_id, self.machine.time)

    def _handle(self, arbitration_id: int, data: bytes) -> None:
        if arbitration_id == _SYNC:
            self._synchronise()
        else:
            if arbitration_id == _NMT and data[:1] in _RESETS:
                self._renumber(data[1:])
            for drive in self.drives:
                drive.receive(arbitration_id, data, self.machine.time)
            self._flush()

    def _renumber(self, node: bytes) -> None:
        """Let the node ids take effect that LSS has stored in the nodes that are reset."""
        ids = {drive.drive.node_id: drive.lss.stored for drive in self.drives if drive.lss.stored}
        ids = {old: new for old, new in ids.items() if node in (bytes([old]), b"\0")}
        drives = (d.model_copy(update={"node_id": ids.get(d.node_id, d.node_id)}) for d in self._rig.drives)
        before, self._rig = self._rig.drives, self._rig.model_copy(update={"drives": tuple(drives)})
        for joint, drive in enumerate(before):
            if drive.node_id in ids:
                self.drives[joint] = self._new_drive(joint)

    def _synchronise(self) -> None:
        if not self._lockstep:
            self._lock_to_sync()
        machine = self.machine
        measured = zip(machine.encoder_counts(), machine.voltages(), machine.torque(), strict=True)
        for drive, (counts, voltage, torque) in zip(self.drives, measured, strict=True):
            drive.synchronise(counts, voltage, torque, machine.time)
        self._flush()
        if self._lockstep:
            # Events before the next SYNC are sent with the next answer, so that the order of frames does not depend
            # on thread scheduling.
            self._advance(self._period)

    def _measure_voltage(self, joint: int) -> float:
        return self.machine.voltages()[joint]

    # Simulated time

    def _catch_up(self) -> None:
        """Real time: advance the machine to the host's time, but not beyond the next expected SYNC."""
        now = self._now()
        if self._last_sync is not None and now < self._last_sync + 1.5 * self._period:
            now = min(now, self._last_sync + self._period)
        self._advance(now - self.machine.time)
        self._flush()

    def _keep_up(self) -> None:
        """Real time: let no burst of frames, such as a set-up by SDO, hold the machine up, so that a heartbeat is not
        heard in its past and lost at once."""
        if time.perf_counter() - self._clock_zero - self.machine.time > _BURST:
            self._catch_up()

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
