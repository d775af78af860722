"""A CAN bus with scripted frames: those that must be sent, and the answers to them."""

from collections import deque

import can

Frame = tuple[int, str]
"""Arbitration id and data in hex."""


class ScriptedBus(can.BusABC):
    """Fails the test when a frame that is sent is not the next one of the script."""

    def __init__(self, script: list[tuple[Frame, list[Frame]]]) -> None:
        super().__init__("script")
        self._is_shutdown = True  # holds no resource that python-can would warn about
        self._script = deque(script)
        self._inbox: deque[Frame] = deque()
        self._errors: deque[Frame] = deque()

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        sent = (msg.arbitration_id, bytes(msg.data).hex(" "))
        assert self._script, f"nothing more expected, sent {sent[0]:03X} {sent[1]}"
        expected, answers = self._script.popleft()
        assert sent == expected, f"expected {expected[0]:03X} {expected[1]}, sent {sent[0]:03X} {sent[1]}"
        self._inbox.extend(answers)

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if self._errors:
            arbitration_id, data = self._errors.popleft()
            message = can.Message(arbitration_id=arbitration_id, data=bytes.fromhex(data), is_error_frame=True)
            return message, False
        if not self._inbox:
            return None, False
        arbitration_id, data = self._inbox.popleft()
        return can.Message(arbitration_id=arbitration_id, data=bytes.fromhex(data), is_extended_id=False), False

    def receive_first(self, *frames: Frame) -> None:
        """Receive unsolicited frames next."""
        self._inbox.extend(frames)

    def receive_error(self, arbitration_id: int, data: str) -> None:
        """Receive an error frame next."""
        self._errors.append((arbitration_id, data))

    def assert_finished(self) -> None:
        assert not self._script, f"{len(self._script)} expected frames were never sent: {self._script[0]}"
