"""A serial port with a script: commands that must be sent, and the replies to them."""

import os
from collections import deque
from typing import Any

from drivers.serial.line import SerialLine
from recordings.buses import SerialBus

Exchange = tuple[str, str | bytes]
"""A command and its reply, both without their ends; "" means no reply, bytes are returned unchanged."""


class ScriptedPort:
    """Fails the test when a command is not the next one of the script."""

    def __init__(self, script: list[Exchange]) -> None:
        self._script = deque(script)
        self._out, self._in = os.pipe()
        os.set_blocking(self._out, False)
        self.sent: list[str] = []

    def write(self, data: bytes) -> None:
        assert data.endswith(b"\r")
        command = data[:-1].decode()
        self.sent.append(command)
        assert self._script, f"nothing more expected, '{command}' sent"
        expected, reply = self._script.popleft()
        assert command == expected, f"'{expected}' expected, '{command}' sent"
        if isinstance(reply, bytes):
            self.arrive(reply)
        elif reply:
            self.arrive(reply.encode() + b"\r")

    def arrive(self, data: bytes) -> None:
        """Receive unsolicited bytes."""
        os.write(self._in, data)

    def read(self, size: int) -> bytes:
        try:
            data = os.read(self._out, size)
        except BlockingIOError:
            return b""
        if not data:
            raise OSError("unplugged")
        return data

    def fileno(self) -> int:
        return self._out

    def unplug(self) -> None:
        """Make the port fail from now on."""
        os.close(self._in)

    def close(self) -> None:
        os.close(self._out)

    def assert_finished(self) -> None:
        assert not self._script, f"{len(self._script)} expected commands were never sent: {self._script[0]}"


def line_on(port: Any, name: str = "port", *, echo: bool = False, **times: float) -> SerialLine:
    """A line without transmission time."""
    bus = SerialBus(baud=10**9, echo=echo, **({"turnaround": 0.002, "reply_timeout": 0.02} | times))
    return SerialLine(port, name, bus)
