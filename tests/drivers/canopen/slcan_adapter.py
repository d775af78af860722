"""An adapter with the slcan protocol at the end of a pseudo-terminal, connected to a virtual CAN bus."""

import os
import pty
import select
import threading
import tty
from typing import Self

import can


class SlcanAdapter:
    """Passes frames between the terminal `path` and the virtual bus `channel` inside the block."""

    def __init__(self, channel: str) -> None:
        self._bus = can.Bus(interface="virtual", channel=channel)
        self._end, other = pty.openpty()
        tty.setraw(other)
        self.path = os.ttyname(other)
        self._other = other
        self.commands: list[bytes] = []
        """What was commanded besides frames, e.g. S8 for 1 Mbit/s."""
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._pass_frames)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._closing.set()
        self._thread.join()
        self._bus.shutdown()
        os.close(self._end)
        os.close(self._other)

    def _pass_frames(self) -> None:
        rest = b""
        while not self._closing.is_set():
            if select.select([self._end], [], [], 0.001)[0]:
                *lines, rest = (rest + os.read(self._end, 4096)).split(b"\r")
                for line in lines:
                    self._obey(line)
            while (frame := self._bus.recv(0.0)) is not None:
                os.write(self._end, f"t{frame.arbitration_id:03X}{frame.dlc}{frame.data.hex().upper()}\r".encode())

    def _obey(self, line: bytes) -> None:
        if line[:1] == b"t":
            data = bytes.fromhex(line[5:].decode())
            self._bus.send(can.Message(arbitration_id=int(line[1:4], 16), data=data, is_extended_id=False))
        else:
            self.commands.append(line)
