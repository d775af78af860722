from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.serial.protocol import CommandRefused, InvalidReply, LineError, Reply, ask, ask_integer, parse, tell


@pytest.mark.parametrize(
    ("line", "reply"),
    [
        (b"ok", Reply("ok")),
        (b"v -123", Reply("v", "-123")),
        (b"v XTL-230-40", Reply("v", "XTL-230-40")),
        (b"e 14", Reply("e", "14")),
    ],
)
def test_valid_replies(line: bytes, reply: Reply) -> None:
    assert parse(line) == reply


@pytest.mark.parametrize(
    "line", [b"", b"OK", b"o", b"ok ", b"v", b"v ", b"v \x00", b"v 1\xff", b"e", b"e x", b"e -1"]
)
def test_invalid_replies(line: bytes) -> None:
    with pytest.raises(InvalidReply, match="reply expected"):
        parse(line)


@given(st.binary(max_size=300))
def test_any_line_is_a_reply_or_invalid(line: bytes) -> None:
    with suppress(InvalidReply):
        assert parse(line).kind in ("ok", "v", "e")


@given(st.sampled_from([ask, ask_integer, tell]), st.binary(max_size=20))
def test_subscripts_accept_or_refuse_any_reply(subscript, line: bytes) -> None:
    script = subscript("1 g r0x32")
    assert next(script) == "1 g r0x32"
    try:
        reply = parse(line)
        script.send(reply)
    except (LineError, StopIteration):
        return
    pytest.fail("one reply is the end of it")


def answer(script, reply: Reply) -> object:
    next(script)
    with pytest.raises(StopIteration) as end:
        script.send(reply)
    return end.value.value


def test_values_of_replies() -> None:
    assert answer(ask_integer("g r0x32"), Reply("v", "-2147483648")) == -(2**31)
    assert answer(ask("g f0x80"), Reply("v", "model 3")) == "model 3"
    assert answer(tell("t 1"), Reply("ok")) is None


@pytest.mark.parametrize(
    ("script", "reply", "problem"),
    [
        (ask_integer("g r0x32"), Reply("ok"), "a value expected in reply to 'g r0x32', 'ok' found"),
        (ask_integer("g r0x32"), Reply("v", "12a"), "a whole number expected in reply to 'g r0x32', '12a' found"),
        (ask_integer("g r0x32"), Reply("v", "1" * 11), "a whole number expected"),
        (tell("t 1"), Reply("v", "12"), "'ok' expected in reply to 't 1', the value '12' found"),
        (tell("t 1"), Reply("e", "33"), r"'t 1' reached the drive disturbed \(e 33\)"),
    ],
)
def test_unexpected_replies(script, reply: Reply, problem: str) -> None:
    next(script)
    with pytest.raises(InvalidReply, match=problem):
        script.send(reply)


@pytest.mark.parametrize(
    ("code", "text"),
    [
        ("9", r"refuses 's r0xca 5': unknown register \(e 9\)"),
        ("10", "value out of range"),
        ("77", r"unknown error \(e 77\)"),
    ],
)
def test_text_of_error_codes(code: str, text: str) -> None:
    script = tell("s r0xca 5")
    next(script)
    with pytest.raises(CommandRefused, match=text) as refusal:
        script.send(Reply("e", code))
    assert refusal.value.code == int(code)
