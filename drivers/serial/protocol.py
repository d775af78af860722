"""The ASCII drive protocol: commands, replies, error codes.

A command ends with a carriage return; the reply is `ok`, `v VALUE` or `e CODE`. A script is a generator that yields
commands and receives their replies. A subscript is a part of one, called by `yield from`.
"""

import re
from collections.abc import Generator
from dataclasses import dataclass
from typing import Literal

from recordings.errors import RunFailed

END = b"\r"
LONGEST_REPLY = 14
"""Number of characters of `v -2147483648` with its end."""
_INTEGER = re.compile(r"-?[0-9]{1,10}")
_CODE = re.compile(r"[0-9]{1,4}")

_ERRORS = {
    1: "too much data passed with the command",
    3: "unknown command",
    4: "not enough data supplied with the command",
    5: "too much data supplied with the command",
    9: "unknown register",
    10: "value out of range",
    11: "register is read-only",
    14: "not possible in the state of the axis",
    15: "register does not exist on this page",
    16: "illegal serial port forwarding",
    18: "a move cannot start while moving",
    19: "illegal velocity limit",
    20: "illegal acceleration limit",
    21: "illegal deceleration limit",
    22: "illegal jerk limit",
    25: "invalid trajectory mode",
    27: "not allowed while a program runs in the drive",
    31: "invalid node id for serial port forwarding",
    32: "CAN communication failed",
    33: "command not understood",
}
"""Copley-style error codes."""
_TRANSMISSION_ERRORS = (3, 33)
"""Error codes of a correct command that was disturbed on the line."""


class LineError(Exception):
    """Error between a command and its reply."""


class InvalidReply(LineError):
    """The characters received are not a reply to the command."""


class ReplyTimeout(LineError):
    """No reply in time."""


class LineLost(RunFailed):
    """The port no longer exists."""


class CommandRefused(LineError):
    """The drive replied `e CODE`."""

    def __init__(self, command: str, code: int) -> None:
        self.code = code
        super().__init__(f"the drive refuses '{command}': {_ERRORS.get(code, 'unknown error')} (e {code})")


@dataclass(frozen=True)
class Reply:
    """One reply; `text` is the value of `v` or the code of `e`, and empty with `ok`."""

    kind: Literal["ok", "v", "e"]
    text: str = ""


Script = Generator[str, Reply, None]


def parse(line: bytes) -> Reply:
    """Parse one reply without its end.

    Raises:
        InvalidReply: the line is no reply.
    """
    text = line.decode("ascii", "replace")
    kind, _, argument = text.partition(" ")
    if text == "ok":
        return Reply("ok")
    if kind == "v" and argument.isprintable() and argument.isascii() and argument.strip():
        return Reply("v", argument.strip())
    if kind == "e" and _CODE.fullmatch(argument):
        return Reply("e", argument)
    raise InvalidReply(f"a reply expected, {line!r} found")


def ask(command: str) -> Generator[str, Reply, str]:
    """Subscript: the value in the reply to a command.

    Raises:
        CommandRefused: the drive replied with an error.
        InvalidReply: the reply has no value.
    """
    reply = yield command
    _check_error(command, reply)
    if reply.kind != "v":
        raise InvalidReply(f"a value expected in reply to '{command}', 'ok' found")
    return reply.text


def ask_integer(command: str) -> Generator[str, Reply, int]:
    """Subscript: `ask` for an integer."""
    text = yield from ask(command)
    if not _INTEGER.fullmatch(text):
        raise InvalidReply(f"a whole number expected in reply to '{command}', {text!r} found")
    return int(text)


def tell(command: str) -> Generator[str, Reply, None]:
    """Subscript: a command whose reply is `ok`. Raises as `ask`."""
    reply = yield command
    _check_error(command, reply)
    if reply.kind != "ok":
        raise InvalidReply(f"'ok' expected in reply to '{command}', the value {reply.text!r} found")


def _check_error(command: str, reply: Reply) -> None:
    if reply.kind == "e":
        code = int(reply.text)
        raise (
            InvalidReply(f"'{command}' reached the drive disturbed (e {code})")
            if code in _TRANSMISSION_ERRORS
            else CommandRefused(command, code)
        )
