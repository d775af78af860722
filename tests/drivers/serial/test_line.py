from collections.abc import Generator

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.serial import line as module
from drivers.serial.line import SerialLine, converse
from drivers.serial.protocol import (
    InvalidReply,
    LineError,
    LineLost,
    Reply,
    ReplyTimeout,
    Script,
    ask,
    ask_integer,
    tell,
)
from tests.drivers.serial.scripted_port import Exchange, ScriptedPort, line_on


def say(line: SerialLine, subscript: Generator[str, Reply, object], timeout: float = 2.0) -> object:
    """Result of a subscript; raises its error."""
    result: list[object] = []

    def script() -> Script:
        result.append((yield from subscript))

    failure = converse({line: script()}, module.time.perf_counter() + timeout).get(line)
    if failure is not None:
        raise failure
    return result[0]


def test_lines_run_in_parallel() -> None:
    """The reply on the first line arrives only after the second line has replied."""
    first, second = ScriptedPort([("g r0x32", "")]), ScriptedPort([("g r0x32", "v 2"), ("t 1", "ok")])
    replies: list[int] = []

    def script() -> Script:
        replies.append((yield from ask_integer("g r0x32")))
        first.arrive(b"v 1\r")
        yield from tell("t 1")

    def slow() -> Script:
        replies.append((yield from ask_integer("g r0x32")))

    failures = converse({line_on(first): slow(), line_on(second): script()}, module.time.perf_counter() + 2.0)
    assert not failures
    assert replies == [2, 1]


def test_reply_may_arrive_in_pieces_and_with_line_feeds() -> None:
    port = ScriptedPort([("g r0x32", "")])
    line = line_on(port)
    line.send("g r0x32")
    for piece in (b"v", b" 1", b"2"):
        port.arrive(piece)
        assert line.receive() is None
    port.arrive(b"\r\n")
    assert line.receive() == Reply("v", "12")


@pytest.mark.parametrize(
    ("first", "late", "error", "text"),
    [
        ("", b"", ReplyTimeout, "no reply in time"),
        (b"v 12", b"", ReplyTimeout, "no reply in time"),
        ("", b"v 1\r", ReplyTimeout, "no reply in time"),
        ("v 1\rv 2", b"\xff\x00 more of it", InvalidReply, "one reply expected"),
        ("g r0x32", b"", InvalidReply, r"set bus\.echo = true"),
    ],
)
def test_lost_late_and_invalid_replies_are_errors_and_never_answer_the_next_command(
    first: str | bytes, late: bytes, error: type[LineError], text: str
) -> None:
    port = ScriptedPort([("g r0x32", first), ("g r0x15", "v 2")])
    line = line_on(port)
    with pytest.raises(error, match=text):
        say(line, ask("g r0x32"))
    port.arrive(late)
    assert say(line, ask("g r0x15")) == "2"


def test_what_was_not_requested_is_discarded() -> None:
    port = ScriptedPort([("", "e 33"), ("g r0x32", "v 3")])
    port.arrive(b"v 99\r")
    line = line_on(port)
    line.flush()
    assert say(line, ask("g r0x32")) == "3"


def test_command_is_not_sent_on_a_line_that_is_never_quiet() -> None:
    class Babbler(ScriptedPort):
        def read(self, size: int) -> bytes:
            return b"x" * size

    port = Babbler([])
    with pytest.raises(ReplyTimeout, match="no silence"):
        say(line_on(port), ask("g r0x32"), timeout=0.02)
    assert not port.sent


def test_echo_is_removed_and_a_disturbed_one_invalid() -> None:
    script: list[Exchange] = [("2 g r0x32", "2 g r0x32\rv 5"), ("g r0x32", "g r0y32\rv 5")]
    line = line_on(ScriptedPort(script), echo=True)
    assert say(line, ask("2 g r0x32")) == "5"
    with pytest.raises(InvalidReply, match="echo of b'g r0x32' expected"):
        say(line, ask("g r0x32"))


class Noise(ScriptedPort):
    """A port that receives arbitrary bytes."""

    def __init__(self, chunks: list[bytes]) -> None:
        super().__init__([])
        self._chunks = iter(chunks)
        self.arrive(b"!")  # readable for select until all has been read

    def write(self, data: bytes) -> None:
        pass

    def read(self, size: int) -> bytes:
        chunk = next(self._chunks, None)
        return super().read(size) and b"" if chunk is None else chunk[:size]

    def close(self) -> None:
        super().close()
        self.unplug()


CHUNK = st.one_of(
    st.binary(max_size=400),
    st.sampled_from([b"ok\r", b"v 12\r", b"e 3\r", b"e 9\r", b"\r", b"\n", b"ok", b"v ", b"1\r", b"g r0x32\r"]),
)


@settings(max_examples=300, deadline=None)
@given(st.lists(CHUNK, max_size=30), st.booleans())
def test_line_survives_any_bytes(chunks: list[bytes], echo: bool) -> None:
    line = line_on(Noise(chunks), echo=echo, turnaround=1e-4, reply_timeout=5e-4)

    def script() -> Script:
        yield from ask_integer("g r0x32")
        yield from tell("s r0xca 1")
        yield from ask("g f0x80")

    for _ in range(3):
        failure = converse({line: script()}, module.time.perf_counter() + 2e-3).get(line)
        assert failure is None or isinstance(failure, LineError)
        assert not isinstance(failure, LineLost)
        assert len(line._buffer) <= 256 + 400
    line.close()
