"""The simulated rig on serial lines: three simulated drives around one machine, behind pseudo-terminals.

Two paces. Lockstep: simulated time stands still while the drives are spoken to, and advances by one period with the
command `latch` to any of them, which plays the role of SYNC. The same seed gives the same replies.
Real time: the machine follows the host's clock, and commands and replies take the time that their characters take on
a wire; a pseudo-terminal has none.
"""

import heapq
import os
import select
import time
import tty
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from itertools import count
from pathlib import Path

import numpy as np

from drivers.serial import port as serial_port
from drivers.serial.axis import LATCH
from drivers.serial.protocol import END
from drivers.simulated.config import SimConfig
from drivers.simulated.machine import Counts, Machine
from drivers.simulated.serial_drive import SimulatedSerialDrive
from drivers.simulated.service import FALLING_BEHIND, Pace, Service, advance_machine
from recordings.errors import BadInput
from recordings.rig import Rig

_CHUNK = 0.001
"""Real time: the machine is advanced at least this often [s], so that little is left to do when a command comes."""
_REACTION = 0.0001
"""Real time: what a drive takes to begin its reply [s]; the rest of the rig's turn-around is the host's."""
_IDLE = 0.05
"""Lockstep: how often the loop looks whether it shall end [s]."""


class SerialRig(Service):
    """The drives of a rig whose transport is serial, on pseudo-terminals."""

    def __init__(self, rig: Rig, config: SimConfig, *, pace: Pace, seed: int) -> None:
        """
        Raises:
            BadInput: a port's name is taken by something else.
        """
        super().__init__()
        self.machine = Machine(rig, config, np.random.default_rng(seed))
        self.disturb: Callable[[str, bytes], bytes] = lambda port, reply: reply
        """What becomes of a reply on its way, for experiments with a bad line."""
        self._bus = rig.serial
        self._character = rig.serial.character
        self._period = 1.0 / rig.rate
        self._lockstep = pace == "lockstep"
        self._voltages: Counts | None = None
        self._clock_zero = 0.0
        self._events: list[tuple[float, int, Callable[[], None]]] = []
        self._order = count()
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

    # Life

    def run(self) -> None:
        """See `Service`."""
        self._clock_zero = time.perf_counter() - self.machine.time
        while not self._stopping.is_set():
            for port in self._readable():
                for command in port.read():
                    self._receive(port, command)
            if not self._lockstep:
                self._work_off()

    def leave(self) -> None:
        """See `Service`: the pseudo-terminals are gone, and the links to them."""
        for port in self._ports:
            port.close()

    def unplug(self, name: str) -> None:
        """Take a line away, as by pulling its cable."""
        next(port for port in self._ports if port.name == name).unplugged = True

    def _readable(self) -> list["_Port"]:
        for port in self._ports:
            if port.unplugged:
                port.close()
        self._ports = [port for port in self._ports if not port.unplugged]
        return select.select(self._ports, [], [], self._patience())[0]

    def _patience(self) -> float:
        if self._lockstep:
            return _IDLE
        due = self._events[0][0] - time.perf_counter() if self._events else _CHUNK
        return min(max(0.0, due), _CHUNK)

    # The wire

    def _receive(self, port: "_Port", command: str) -> None:
        """A command has been written to the pseudo-terminal; on a wire its last character comes later."""
        if self._lockstep:
            self._answer(port, command)
            return
        # A whole command is written at once, so the line is free or still busy with the one before.
        port.busy_until = max(time.perf_counter(), port.busy_until) + (len(command) + 1) * self._character
        self._at(port.busy_until, lambda: self._hear(port, command))

    def _hear(self, port: "_Port", command: str) -> None:
        self._catch_up(port.busy_until)
        self._answer(port, command)

    def _answer(self, port: "_Port", command: str) -> None:
        if self._bus.echo:
            port.write(command.encode() + END)
        drive = next((drive for drive in port.drives if command.startswith(drive.prefix)), None)
        if drive is None:
            return
        said = command.removeprefix(drive.prefix)
        latch = self._lockstep and said == LATCH
        text = "ok" if latch else drive.handle(said, self.machine.time)
        reply = self.disturb(port.name, text.encode() + END)
        if not self._lockstep:
            on_the_wire = len(reply) * self._character
            self._at(port.busy_until + _REACTION + on_the_wire, lambda: port.write(reply))
            return
        port.write(reply)
        if latch:
            self._voltages = None
            self._advance(self._period)

    def _at(self, due: float, action: Callable[[], None]) -> None:
        heapq.heappush(self._events, (due, next(self._order), action))

    def _work_off(self) -> None:
        """Real time: what is due, each at its time."""
        while self._events and self._events[0][0] <= time.perf_counter():
            heapq.heappop(self._events)[-1]()
        self._catch_up(time.perf_counter())

    # The machine

    def _position(self, joint: int) -> int:
        return self.machine.encoder_counts()[joint]

    def _voltage(self, joint: int) -> int:
        # In lockstep drawn once per period, so that it does not matter which line is served first.
        if self._voltages is None or not self._lockstep:
            self._voltages = self.machine.voltage_counts()
        return self._voltages[joint]

    def _catch_up(self, now: float) -> None:
        """Real time: bring the machine to `now` [s] on the host's clock."""
        behind = now - self._clock_zero - self.machine.time
        if behind > FALLING_BEHIND:
            self._clock_zero += behind
        else:
            self._advance(behind)

    def _advance(self, duration: float) -> None:
        if advance_machine(self.machine, self.drives, duration):
            for drive in self.drives:
                drive.update(self.machine.time)


class _Port:
    """One pseudo-terminal under a name: a link in the file system, or known inside this program only."""

    def __init__(self, name: str, drives: list[SimulatedSerialDrive]) -> None:
        self.name = name
        self.drives = drives
        self.busy_until = 0.0
        self.unplugged = False
        self._buffer = b""
        self._link: Path | None = None
        self._controller, device = os.openpty()
        # The recorder's end is kept open here too, so that a recorder may come and go.
        self._open = [self._controller, device]
        tty.setraw(device)
        os.set_blocking(self._controller, False)
        path = os.ttyname(device)
        if name.startswith("simulated"):
            serial_port.simulated[name] = path
        else:
            self._make_link(Path(name), path)

    def _make_link(self, link: Path, path: str) -> None:
        if link.is_symlink() and not link.exists():  # left over from a simulated rig that was killed
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
        """Commands that are complete, without their ends; empty ones are none."""
        with suppress(OSError):
            self._buffer += os.read(self._controller, 4096)
        *commands, self._buffer = self._buffer.split(END)
        return [command.decode("ascii", "replace") for command in commands if command]

    def write(self, data: bytes) -> None:
        """What nobody reads is lost, as on a wire."""
        with suppress(OSError):
            os.write(self._controller, data)

    def close(self) -> None:
        """Hang up; a second time nothing happens."""
        if self._link is not None:
            self._link.unlink(missing_ok=True)
            self._link = None
        serial_port.simulated.pop(self.name, None)
        while self._open:
            os.close(self._open.pop())
