"""The simulated rig on serial lines: three simulated drives around one machine, behind pseudo-terminals.

Two paces. Lockstep: the command `latch` to any drive advances simulated time by one period, as SYNC does on CANopen;
other commands take no time. The same seed gives the same replies.
Real time: the machine follows the host's clock; commands and replies take the transmission time of their characters,
which a pseudo-terminal does not have.
"""

import heapq
import os
import select
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from itertools import count
from pathlib import Path

from drivers.serial import port as serial_port
from drivers.serial.axis import LATCH
from drivers.serial.protocol import END
from drivers.simulated.config import SimConfig
from drivers.simulated.machine import Counts
from drivers.simulated.serial_drive import SimulatedSerialDrive
from drivers.simulated.service import CHUNK, Service, advance_machine
from recordings.errors import BadInput
from recordings.recording import Pace
from recordings.rig import Rig

_REACTION = 0.0001
"""Real time: delay of a drive before its reply [s]; the rest of the rig's turnaround is the host's."""
_IDLE = 0.05
"""Lockstep: interval at which the loop checks whether to end [s]."""


class SerialRig(Service):
    """The drives of a rig whose transport is serial, on pseudo-terminals."""

    def __init__(self, rig: Rig, config: SimConfig, *, pace: Pace, seed: int) -> None:
        """
        Raises:
            BadInput: the name of a port is in use.
        """
        super().__init__(rig, config, pace, seed)
        self.disturb: Callable[[str, bytes], bytes] = lambda port, reply: reply
        """Changes a reply on the line, for tests with disturbances."""
        self._bus = rig.serial
        self._character = rig.serial.character
        self._voltages: Counts | None = None
        self._events: list[tuple[float, int, Callable[[], None]]] = []
        self._event_number = count()
        self.drives = [
            SimulatedSerialDrive(
                rig,
                j + 1,
                self.machine.dt,
                partial(self._position, j),
                partial(self._voltage, j),
                lockstep=self._lockstep,
            )
            for j in range(rig.dof)
        ]
        self._ports: list[_Port] = []
        try:
            for name in rig.serial.ports:
                self._ports.append(_Port(name, [drive for drive in self.drives if drive.port == name]))
        except BadInput:
            self.leave()
            raise

    # Life cycle

    def run(self) -> None:
        """See `Service`."""
        self._start_clock()
        while not self._stopping.is_set():
            for port in self._readable():
                for command in port.read():
                    self._receive(port, command)
            if not self._lockstep:
                self._run_events()

    def leave(self) -> None:
        """See `Service`: remove the pseudo-terminals and the links to them."""
        for port in self._ports:
            port.close()

    def unplug(self, name: str) -> None:
        """Remove a line, as by pulling its cable."""
        next(port for port in self._ports if port.name == name).unplugged = True

    def _readable(self) -> list["_Port"]:
        for port in self._ports:
            if port.unplugged:
                port.close()
        self._ports = [port for port in self._ports if not port.unplugged]
        return select.select(self._ports, [], [], self._select_timeout())[0]

    def _select_timeout(self) -> float:
        if self._lockstep:
            return _IDLE
        due = self._events[0][0] - time.perf_counter() if self._events else CHUNK
        return min(max(0.0, due), CHUNK)

    # The line

    def _receive(self, port: "_Port", command: str) -> None:
        """Process a command written to the pseudo-terminal; on a real line its last character arrives later."""
        if self._lockstep:
            self._reply_to(port, command)
            return
        # A whole command is written at once, so the line is free or still busy with the previous command.
        port.busy_until = max(time.perf_counter(), port.busy_until) + (len(command) + 1) * self._character
        self._at(port.busy_until, lambda: self._process(port, command))

    def _process(self, port: "_Port", command: str) -> None:
        self._catch_up(port.busy_until)
        self._reply_to(port, command)

    def _reply_to(self, port: "_Port", command: str) -> None:
        if self._bus.echo:
            port.write(command.encode() + END)
        drive = next((drive for drive in port.drives if command.startswith(drive.prefix)), None)
        if drive is None:
            return
        text = command.removeprefix(drive.prefix)
        latch = self._lockstep and text == LATCH
        answer = "ok" if latch else drive.handle(text, self.machine.time)
        reply = self.disturb(port.name, answer.encode() + END)
        if not self._lockstep:
            on_the_wire = len(reply) * self._character
            self._at(port.busy_until + _REACTION + on_the_wire, lambda: port.write(reply))
            return
        port.write(reply)
        if latch:
            self._voltages = None
            self._advance(self._period)

    def _at(self, due: float, action: Callable[[], None]) -> None:
        heapq.heappush(self._events, (due, next(self._event_number), action))

    def _run_events(self) -> None:
        """Real time: run the events that are due, in order."""
        while self._events and self._events[0][0] <= time.perf_counter():
            heapq.heappop(self._events)[-1]()
        self._catch_up(time.perf_counter())

    # The machine

    def _position(self, joint: int) -> int:
        return self.machine.encoder_counts()[joint]

    def _voltage(self, joint: int) -> int:
        # In lockstep the noise is drawn once per period, so that the order of the lines does not matter.
        if self._voltages is None or not self._lockstep:
            self._voltages = self.machine.voltage_counts()
        return self._voltages[joint]

    def _catch_up(self, now: float) -> None:
        """Real time: advance the machine to `now` [s] on the host's clock."""
        if not self._is_delayed(now):
            self._advance(now - self._clock_zero - self.machine.time)

    def _advance(self, duration: float) -> None:
        if advance_machine(self.machine, self.drives, duration):
            for drive in self.drives:
                drive.update(self.machine.time)


class _Port:
    """One pseudo-terminal with a name: a link in the file system, or a name known only inside this program."""

    def __init__(self, name: str, drives: list[SimulatedSerialDrive]) -> None:
        self.name = name
        self.drives = drives
        self.busy_until = 0.0
        self.unplugged = False
        self._buffer = b""
        self._link: Path | None = None
        import tty  # of systems that have pseudo-terminals

        self._controller, device = os.openpty()
        # The recorder's end is kept open here as well, so that recorders may connect and disconnect.
        self._open = [self._controller, device]
        tty.setraw(device)
        os.set_blocking(self._controller, False)
        path = os.ttyname(device)
        if name.startswith("simulated"):
            serial_port.simulated[name] = path
        else:
            self._make_link(Path(name), path)

    def _make_link(self, link: Path, path: str) -> None:
        if link.is_symlink() and not link.exists():  # of a simulated rig that was killed
            link.unlink()
        try:
            link.symlink_to(path)
        except OSError as error:
            self.close()
            raise BadInput(
                f"bus.ports: a name for a simulated line expected, {link} cannot be made: {error.strerror}; name "
                "another path in the rig file, e.g. /tmp/delta"
            ) from None
        self._link = link

    def fileno(self) -> int:
        """For `select`."""
        return self._controller

    def read(self) -> list[str]:
        """Complete commands without their ends; empty ones are skipped."""
        with suppress(OSError):
            self._buffer += os.read(self._controller, 4096)
        *commands, self._buffer = self._buffer.split(END)
        return [command.decode("ascii", "replace") for command in commands if command]

    def write(self, data: bytes) -> None:
        """Write characters; they are lost if nobody reads them, as on a real line."""
        with suppress(OSError):
            os.write(self._controller, data)

    def close(self) -> None:
        """Close the pseudo-terminal; may be repeated."""
        if self._link is not None:
            self._link.unlink(missing_ok=True)
            self._link = None
        serial_port.simulated.pop(self.name, None)
        while self._open:
            os.close(self._open.pop())
