"""One serial line: a command, its reply, the next command; back in step after garbage.

Replies carry neither address nor number, so while one may still be under way nothing is sent: it would be taken for
the next one's. `converse` runs a script on each of several lines at the same time.
"""

import select
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, Protocol

import serial

from drivers.serial.protocol import END, LONGEST_REPLY, InvalidReply, LineError, LineLost, Reply, Script, ReplyTimeout, parse

_LONGEST_LINE = 256
"""Without an end so far: garbage."""


class Port(Protocol):
    """What is needed of pyserial's Serial, with its read time-out 0."""

    def fileno(self) -> int: ...
    def read(self, size: int) -> bytes: ...
    def write(self, data: bytes) -> Any: ...
    def close(self) -> None: ...


class SerialLine:
    """One line and what is known about its step."""

    def __init__(
        self,
        port: Port,
        name: str,
        *,
        character: float,
        turnaround: float,
        reply_timeout: float,
        echo: bool,
        least_timeout: float = 0.0,
    ) -> None:
        """`character`: time on the wire of one [s]; the other times [s] as in the rig file, `patience`: longer than
        the time-out where replies surely come (time is simulated)."""
        self.name = name
        self.lost = False
        self._port = port
        self._character = character
        self._reply_timeout = reply_timeout
        self._patience = max(reply_timeout, least_timeout)
        # Silence after which nothing more belongs to what came before.
        self._quiet = LONGEST_REPLY * character + turnaround
        self._echo = echo
        self._sent = b""
        self._awaiting = False
        self._buffer = b""
        self._latest_reply = 0.0
        self._out_of_step_until: float | None = None
        self._reply_owed = False

    def fileno(self) -> int:
        """For `select`."""
        return self._port.fileno()

    def flush(self) -> None:
        """End what the drives may hold of a broken command, and let all replies to it pass.

        Raises:
            LineLost: the port is gone.
        """
        self._write(END)
        self._fall_out(time.perf_counter() + self._quiet + self._reply_timeout)

    def send(self, command: str) -> float:
        """Send a command; returns when a reply is no longer to be expected [s, perf_counter].

        Raises:
            LineLost: the port is gone.
        """
        self._sent = command.encode("ascii")
        self._awaiting = True
        self._write(self._sent + END)
        on_the_wire = (len(self._sent) + 1 + LONGEST_REPLY) * self._character
        self._latest_reply = time.perf_counter() + on_the_wire + self._patience
        return self._latest_reply

    def receive(self) -> Reply | None:
        """Take in what has arrived; a reply where it is complete. Does not wait.

        Raises:
            Garbage: what came is no reply; the line is out of step.
            LineLost: the port is gone.
        """
        self._buffer = (self._buffer + self._read()).lstrip(END)
        if self._out_of_step_until is not None:
            self._discard()
            return None
        if not self._awaiting:
            if self._buffer:
                self.resynchronize()
            return None
        try:
            return self._take_reply()
        except InvalidReply:
            self.resynchronize()
            raise

    def _take_reply(self) -> Reply | None:
        *lines, rest = self._buffer.split(END)
        if self._echo and lines and lines.pop(0) != self._sent:
            raise InvalidReply(f"the echo of {self._sent!r} expected, {self._buffer[:40]!r} found")
        if len(rest) > _LONGEST_LINE or len(lines) > 1 or (lines and rest):
            raise InvalidReply(f"one reply expected, {self._buffer[:40]!r} found")
        if not lines:
            return None
        if not self._echo and lines[0] == self._sent:
            raise InvalidReply(f"the reply to {self._sent!r} expected, the command itself found; set bus.echo = true")
        self._reset()
        return parse(lines[0])

    def synchronized(self, now: float) -> bool:
        """Whether a command may be sent."""
        if self._out_of_step_until is not None and now >= self._out_of_step_until:
            self._reset()
        return self._out_of_step_until is None

    @property
    def synchronized_at(self) -> float:
        """When that will be so if nothing more arrives [s]."""
        return self._out_of_step_until or 0.0

    def resynchronize(self) -> None:
        """What arrived is not the reply: it and all that follows without a pause is thrown away."""
        self._buffer = b""
        self._fall_out(time.perf_counter() + self._quiet)

    def abandon_reply(self) -> None:
        """The reply did not come in time; it may come later."""
        self._fall_out(self._latest_reply)
        self._reply_owed = True

    def _fall_out(self, until: float) -> None:
        self._out_of_step_until = until
        self._reply_owed = False

    def _discard(self) -> None:
        """Out of step: throw away what comes, unless it is the very reply that is late."""
        if not self._reply_owed or len(self._buffer) > _LONGEST_LINE:
            if self._buffer:
                self.resynchronize()
            return
        try:
            self._take_reply()
        except InvalidReply:
            self.resynchronize()

    def _reset(self) -> None:
        """In step, nothing under way."""
        self._out_of_step_until = None
        self._awaiting = False
        self._buffer = b""

    def close(self) -> None:
        """Release the port."""
        with suppress(serial.SerialException, OSError):
            self._port.close()

    def _read(self) -> bytes:
        try:
            return self._port.read(4096).replace(b"\n", b"")
        except (serial.SerialException, OSError) as error:
            raise self._gone(error) from None

    def _write(self, data: bytes) -> None:
        try:
            self._port.write(data)
        except (serial.SerialException, OSError) as error:
            raise self._gone(error) from None

    def _gone(self, error: Exception) -> LineLost:
        self.lost = True
        return LineLost(f"serial port {self.name} is lost ({error}); check cable and adapter")


def converse(scripts: Mapping[SerialLine, Script], deadline: float) -> dict[SerialLine, LineError]:
    """Run each script on its line, all lines at the same time, until `deadline` [s, perf_counter].

    Garbage, and silence in place of a reply, are thrown into the script, which may catch them and go on; what it says
    next waits until the line is in step. Returns what ended a script before its time, by line. Other exceptions of a
    script pass.
    """
    talks = [_Talk(line, script) for line, script in scripts.items()]
    while True:
        for talk in talks:
            talk.step(deadline)
        waiting = [talk for talk in talks if not talk.over]
        if not waiting:
            return {talk.line: talk.failure for talk in talks if talk.failure is not None}
        wake = min(deadline, *(talk.wake for talk in waiting))
        select.select([talk.line for talk in waiting], [], [], max(0.0, wake - time.perf_counter()))


class _Talk:
    """One script on its line."""

    def __init__(self, line: SerialLine, script: Script) -> None:
        self.line = line
        self.over = False
        self.failure: LineError | None = None
        self._script = script
        self._command: str | None = None
        """To be sent as soon as the line is in step."""
        self._due = 0.0
        """Of the reply, when it has been sent [s]."""
        self._proceed(lambda: next(script))

    @property
    def wake(self) -> float:
        """When something is to be done even if nothing arrives [s]."""
        return self._due if self._command is None else self.line.synchronized_at

    def step(self, deadline: float) -> None:
        """Do what can be done now."""
        while not self.over and self._step(deadline):
            pass

    def _step(self, deadline: float) -> bool:
        """One thing; whether there may be more to do."""
        try:
            reply = self.line.receive()
            now = time.perf_counter()
            if self._command is not None:
                return self._send(self._command, now, deadline)
            if reply is not None:
                self._proceed(lambda: self._script.send(reply))
                return True
            if now < min(self._due, deadline):
                return False
            self.line.abandon_reply()
            error: LineError = ReplyTimeout("no reply in time")
        except LineLost as lost:
            self._end(lost)
            return False
        except InvalidReply as garbage:
            error = garbage
        if time.perf_counter() >= deadline:
            self._end(error)
        else:
            self._proceed(lambda: self._script.throw(error))
        return True

    def _send(self, command: str, now: float, deadline: float) -> bool:
        if self.line.synchronized(now):
            self._due = self.line.send(command)
            self._command = None
        elif now >= deadline:
            self._end(ReplyTimeout("no silence on the line after a disturbance"))
        else:
            return False
        return True

    def _proceed(self, say: Callable[[], str]) -> None:
        """Let the script come to its next command."""
        try:
            self._command = say()
        except StopIteration:
            self._end(None)
        except InvalidReply as garbage:
            self.line.resynchronize()
            self._end(garbage)
        except LineError as error:
            self._end(error)

    def _end(self, failure: LineError | None) -> None:
        self.over, self.failure = True, failure
        self._script.close()
