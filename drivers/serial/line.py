"""One serial line: commands alternate with replies; resynchronization after an invalid or late reply.

Replies carry neither address nor number, so nothing is sent while one may still arrive: it would be taken for the
reply to the next command. `converse` runs one script on each of several lines in parallel.
"""

import select
import time
from collections.abc import Callable, Mapping
from contextlib import suppress

import serial

from drivers.serial.protocol import (
    END,
    LONGEST_REPLY,
    InvalidReply,
    LineError,
    LineLost,
    Reply,
    ReplyTimeout,
    Script,
    parse,
)
from recordings.buses import SerialBus

_MAX_LINE = 256
"""Longest line without an end character [bytes]; a longer one is invalid."""


class SerialLine:
    """One line and its synchronization state."""

    def __init__(
        self,
        port: serial.Serial,
        name: str,
        bus: SerialBus,
        least_timeout: float = 0.0,
    ) -> None:
        """`port`: with read timeout 0; `least_timeout`: lower bound of the reply timeout [s], for simulated time."""
        self.name = name
        self.lost = False
        self._port, self._bus = port, bus
        self._reply_wait = max(bus.reply_timeout, least_timeout)
        self.patience = 0.0
        """Lower bound of the reply timeout where no cycle waits [s]."""
        # Silence after which no more of an earlier reply can arrive.
        self._quiet_time = LONGEST_REPLY * bus.character + bus.turnaround
        self._last_command = b""
        self._reply_pending = False
        self._buffer = b""
        self._latest_reply = 0.0
        self._resync_until: float | None = None
        self._late_reply_possible = False

    def fileno(self) -> int:
        """For `select`."""
        return self._port.fileno()

    def flush(self) -> None:
        """End a partial command that the drives may hold, and wait for the replies to it.

        Raises:
            LineLost: the port is gone.
        """
        self._write(END)
        self._resynchronize_until(time.perf_counter() + self._quiet_time + self._bus.reply_timeout)

    def send(self, command: str) -> float:
        """Send a command; returns the deadline of its reply [s, perf_counter].

        Raises:
            LineLost: the port is gone.
        """
        self._last_command = command.encode("ascii")
        self._reply_pending = True
        self._write(self._last_command + END)
        on_the_wire = (len(self._last_command) + 1 + LONGEST_REPLY) * self._bus.character
        self._latest_reply = time.perf_counter() + on_the_wire + max(self._reply_wait, self.patience)
        return self._latest_reply

    def receive(self) -> Reply | None:
        """Read what has arrived; returns a reply if it is complete. Does not wait.

        Raises:
            InvalidReply: what arrived is no reply; the line resynchronizes.
            LineLost: the port is gone.
        """
        self._buffer = (self._buffer + self._read()).lstrip(END)
        if self._resync_until is not None:
            self._discard()
            return None
        if not self._reply_pending:
            if self._buffer:
                self.resynchronize()
            return None
        try:
            return self._take_reply()
        except InvalidReply:
            self.resynchronize()
            raise

    def _take_reply(self) -> Reply | None:
        *lines, partial = self._buffer.split(END)
        if self._bus.echo and lines and lines.pop(0) != self._last_command:
            raise InvalidReply(f"the echo of {self._last_command!r} expected, {self._buffer[:40]!r} found")
        if len(partial) > _MAX_LINE or len(lines) > 1 or (lines and partial):
            raise InvalidReply(f"one reply expected, {self._buffer[:40]!r} found")
        if not lines:
            return None
        if not self._bus.echo and lines[0] == self._last_command:
            raise InvalidReply(
                f"the reply to {self._last_command!r} expected, the command itself found; set bus.echo = true"
            )
        self._reset()
        return parse(lines[0])

    def synchronized(self, now: float) -> bool:
        """Whether a command may be sent."""
        if self._resync_until is not None and now >= self._resync_until:
            self._reset()
        return self._resync_until is None

    @property
    def synchronized_at(self) -> float:
        """Time at which the line is synchronized if nothing more arrives [s]."""
        return self._resync_until or 0.0

    def resynchronize(self) -> None:
        """Discard what arrived and all that follows without a pause: it is not the reply."""
        self._buffer = b""
        self._resynchronize_until(time.perf_counter() + self._quiet_time)

    def abandon_reply(self) -> None:
        """Stop waiting for the reply, which may still arrive."""
        self._resynchronize_until(self._latest_reply)
        self._late_reply_possible = True

    def _resynchronize_until(self, until: float) -> None:
        self._resync_until = until
        self._late_reply_possible = False

    def _discard(self) -> None:
        """Discard what arrives during resynchronization, unless it is the late reply."""
        if not self._late_reply_possible or len(self._buffer) > _MAX_LINE:
            if self._buffer:
                self.resynchronize()
            return
        try:
            self._take_reply()
        except InvalidReply:
            self.resynchronize()

    def _reset(self) -> None:
        """Mark the line as synchronized, without a pending reply."""
        self._resync_until = None
        self._reply_pending = False
        self._buffer = b""

    def close(self) -> None:
        """Release the port."""
        with suppress(serial.SerialException, OSError):
            self._port.close()

    def _read(self) -> bytes:
        try:
            return self._port.read(4096).replace(b"\n", b"")
        except (serial.SerialException, OSError) as error:
            raise self._lost_error(error) from None

    def _write(self, data: bytes) -> None:
        try:
            self._port.write(data)
        except (serial.SerialException, OSError) as error:
            raise self._lost_error(error) from None

    def _lost_error(self, error: Exception) -> LineLost:
        self.lost = True
        return LineLost(f"serial port {self.name} is lost ({error}); check cable and adapter")


def converse(scripts: Mapping[SerialLine, Script], deadline: float) -> dict[SerialLine, LineError | LineLost]:
    """Run each script on its line, all lines in parallel, until `deadline` [s, perf_counter].

    InvalidReply and ReplyTimeout are thrown into the script, which may catch them and continue; its next command
    waits until the line is synchronized. Returns the error that ended a script, by line. Other exceptions of a script
    are passed on.
    """
    conversations = [_Conversation(line, script) for line, script in scripts.items()]
    while True:
        for conversation in conversations:
            conversation.step(deadline)
        waiting = [conversation for conversation in conversations if not conversation.over]
        if not waiting:
            return {
                conversation.line: conversation.failure
                for conversation in conversations
                if conversation.failure is not None
            }
        wake = min(deadline, *(conversation.wake for conversation in waiting))
        select.select([conversation.line for conversation in waiting], [], [], max(0.0, wake - time.perf_counter()))


class _Conversation:
    """One script on its line."""

    def __init__(self, line: SerialLine, script: Script) -> None:
        self.line = line
        self.over = False
        self.failure: LineError | LineLost | None = None
        self._script = script
        self._command: str | None = None
        """Command to send as soon as the line is synchronized."""
        self._reply_deadline = 0.0
        """Deadline of the reply to the command sent [s]."""
        self._advance(lambda: next(script))

    @property
    def wake(self) -> float:
        """Time of the next step if nothing arrives [s]."""
        return self._reply_deadline if self._command is None else self.line.synchronized_at

    def step(self, deadline: float) -> None:
        """Make all steps that are possible now."""
        while not self.over and self._step(deadline):
            pass

    def _step(self, deadline: float) -> bool:
        """Make one step; returns whether another may be possible."""
        try:
            reply = self.line.receive()
            now = time.perf_counter()
            if self._command is not None:
                return self._send(self._command, now, deadline)
            if reply is not None:
                self._advance(lambda: self._script.send(reply))
                return True
            if now < min(self._reply_deadline, deadline):
                return False
            self.line.abandon_reply()
            error: LineError = ReplyTimeout("no reply in time")
        except LineLost as lost:
            self._end(lost)
            return False
        except InvalidReply as invalid:
            error = invalid
        if time.perf_counter() >= deadline:
            self._end(error)
        else:
            self._advance(lambda: self._script.throw(error))
        return True

    def _send(self, command: str, now: float, deadline: float) -> bool:
        if self.line.synchronized(now):
            self._reply_deadline = self.line.send(command)
            self._command = None
        elif now >= deadline:
            self._end(ReplyTimeout("no silence on the line after a disturbance"))
        else:
            return False
        return True

    def _advance(self, advance: Callable[[], str]) -> None:
        """Advance the script to its next command."""
        try:
            self._command = advance()
        except StopIteration:
            self._end(None)
        except InvalidReply as invalid:
            self.line.resynchronize()
            self._end(invalid)
        except LineError as error:
            self._end(error)

    def _end(self, failure: LineError | LineLost | None) -> None:
        self.over, self.failure = True, failure
        self._script.close()
