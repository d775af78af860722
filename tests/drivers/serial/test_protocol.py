import pytest

from drivers.serial.protocol import CommandRefused, InvalidReply, LineError, ask, ask_integer, parse, tell


def answer(script, line: bytes) -> object:
    """Result of a subscript that gets this reply."""
    next(script)
    with pytest.raises(StopIteration) as end:
        script.send(parse(line))
    return end.value.value


def test_values_of_replies() -> None:
    assert answer(ask_integer("g r0x32"), b"v -2147483648") == -(2**31)
    assert answer(ask("g f0x80"), b"v XTL-230-40 model 3") == "XTL-230-40 model 3"
    assert answer(tell("t 1"), b"ok") is None


@pytest.mark.parametrize(
    ("script", "line", "error", "problem"),
    [
        (ask_integer("g r0x32"), b"ok", InvalidReply, "a value expected in reply to 'g r0x32', 'ok' found"),
        (
            ask_integer("g r0x32"),
            b"v 12a",
            InvalidReply,
            "a whole number expected in reply to 'g r0x32', '12a' found",
        ),
        (ask_integer("g r0x32"), b"v " + b"1" * 11, InvalidReply, "a whole number expected"),
        (tell("t 1"), b"v 12", InvalidReply, "'ok' expected in reply to 't 1', the value '12' found"),
        (tell("t 1"), b"e 33", InvalidReply, r"'t 1' reached the drive disturbed \(e 33\)"),
        (tell("s r0xca 5"), b"e 9", CommandRefused, r"refuses 's r0xca 5': unknown register \(e 9\)"),
        (tell("s r0xca 5"), b"e 77", CommandRefused, r"unknown error \(e 77\)"),
    ],
)
def test_unexpected_replies(script, line: bytes, error: type[LineError], problem: str) -> None:
    next(script)
    with pytest.raises(error, match=problem):
        script.send(parse(line))


@pytest.mark.parametrize(
    "line", [b"", b"OK", b"o", b"ok ", b"v", b"v ", b"v \x00", b"v 1\xff", b"e", b"e x", b"e -1"]
)
def test_invalid_replies(line: bytes) -> None:
    with pytest.raises(InvalidReply, match="reply expected"):
        parse(line)
