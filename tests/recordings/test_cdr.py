"""CDR encoding compared with two independent implementations: mcap-ros2-support (bytes) and rosbags (types)."""

from functools import reduce
from itertools import chain
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap_ros2._dynamic import serialize_dynamic
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from recordings import schemas
from recordings.cdr import Encoder, Layout, parse_schema

TYPES = dict((schemas.TOPICS | schemas.OPTIONAL_TOPICS).values())
STAMPS = st.tuples(st.integers(0, 2**31 - 1), st.integers(0, 10**9 - 1))
WORDS = {code: st.integers(0, 2**size - 1) for code, size in {"B": 8, "H": 16, "I": 32}.items()}
ELEMENTS: dict[str, st.SearchStrategy[Any]] = {
    **WORDS,
    "i": st.integers(-(2**31), 2**31 - 1),
    "?": st.booleans(),
    "d": st.floats(width=64),
    "iI": STAMPS,
    "s": st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=12),
}
"""By the letters of a field."""


@st.composite
def messages(draw: st.DrawFn) -> tuple[str, dict[str, str], dict[str, int], list[Any], dict[str, Any]]:
    """Any message: type, strings and lengths, values in order, and the content as other libraries take it."""
    name = draw(st.sampled_from(sorted(TYPES)))
    texts: dict[str, str] = {}
    lengths: dict[str, int] = {}
    values: list[Any] = []
    content: dict[str, Any] = {}
    for field in parse_schema(TYPES[name]):
        count = draw(st.integers(0, 5)) if field.count is None else field.count
        drawn = draw(st.lists(ELEMENTS[field.codes], min_size=count, max_size=count))
        if field.count is None:
            lengths[field.name] = count
        if field.codes == "s":
            texts |= {field.name if field.count else f"{field.name}.{i}": text for i, text in enumerate(drawn)}
        else:
            values += chain(*drawn) if field.codes == "iI" else drawn
        given = [{"sec": each[0], "nanosec": each[1]} for each in drawn] if field.codes == "iI" else drawn
        *parents, last = field.name.split(".")
        reduce(lambda inner, parent: inner.setdefault(parent, {}), parents, content)[last] = (
            given[0] if field.count == 1 else given
        )
    return name, texts, lengths, values, content


@given(messages())
def test_messages_are_byte_for_byte_what_mcap_ros2_support_writes(message: tuple[str, Any, Any, Any, Any]) -> None:
    name, texts, lengths, values, content = message
    expected = serialize_dynamic(name, TYPES[name])[name](content)
    assert Encoder(parse_schema(TYPES[name]), texts, lengths).pack(values) == expected


@pytest.mark.parametrize("name", TYPES)
def test_schema_equals_the_message_type_of_rosbags(name: str) -> None:
    ours = get_types_from_msg(TYPES[name], name)
    store = get_typestore(Stores.ROS2_HUMBLE)
    known = {type_name: definition for type_name, definition in ours.items() if type_name in store.fielddefs}
    assert known, "not even the header is known"
    for type_name, definition in known.items():
        assert definition[1] == store.fielddefs[type_name][1]


def test_fits_is_false_for_messages_with_other_lengths() -> None:
    fields = parse_schema(schemas.LOG)

    def packed(source: str, text: str) -> bytes:
        return Encoder(fields, {"name": source, "msg": text, "file": "", "function": ""}, {}).pack([1, 2, 20, 0])

    messages = [packed("abcd", "efgh"), packed("12345678", ""), packed("ijkl", "mnop")]
    layout = Layout.of(fields, messages[0])
    assert len({len(message) for message in messages}) == 1, "the point is that their size is the same"
    assert layout.fits(np.frombuffer(b"".join(messages), layout.dtype)).tolist() == [True, False, True]


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (lambda message: message[:14], "shorter"),
        (lambda message: message[:24], "bytes, its contents"),
        (lambda message: message + b"\0", "bytes, its contents"),
        (lambda message: b"\x00\x00" + message[2:], "little endian"),
        (lambda message: message[:12] + b"\xff\xff\xff\x7f" + message[16:], "shorter"),
    ],
)
def test_invalid_messages_are_refused(spoil, reason) -> None:
    fields = parse_schema(schemas.POINT_STAMPED)
    message = Encoder(fields, {"header.frame_id": "base"}, {}).pack([0, 0, 1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match=reason):
        Layout.of(fields, spoil(message))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("float64", "not a field"),
        ("their_msgs/Thing thing", "their_msgs/Thing of 'thing' is not known"),
        ("wstring name", "wstring"),
        ("a/A[] many\n===\nMSG: a/A\nint8 x", r"a/A\[\] of 'many'"),
        ("a/A one\n===\nMSG: a/A\na/A again", "'one.again'"),
    ],
)
def test_unsupported_schemas_are_refused(text: str, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        parse_schema(text)


def test_parse_schema_accepts_comments_constants_defaults_and_bounds() -> None:
    fields = parse_schema("# a comment\nint8 A=1\nint8 B = 2\n\nint8 x 5 # five\nuint8[<=4] some\nfloat32[2] pair\n")
    assert [(field.name, field.codes, field.count) for field in fields] == [
        ("x", "b", 1),
        ("some", "B", None),
        ("pair", "f", 2),
    ]
