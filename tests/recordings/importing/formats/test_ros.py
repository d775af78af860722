"""ROS bags: topics, order and sets of joints, stamps. Whole files of other libraries are in test_foreign_files."""

import sqlite3
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag2 import Writer
from rosbags.typesys import Stores, get_typestore

from recordings.errors import BadInput
from recordings.importing.formats import read

STORE = get_typestore(Stores.ROS2_HUMBLE)
TYPE = "sensor_msgs/msg/JointState"
NAMES = ("a", "b")


def message(stamp: int, names: Sequence[str], position: Sequence[float], effort: Sequence[float]) -> Any:
    types = STORE.types
    time = types["builtin_interfaces/msg/Time"](*divmod(stamp, 10**9))
    return types[TYPE](
        header=types["std_msgs/msg/Header"](stamp=time, frame_id=""),
        name=list(names),
        position=np.array(position, float),
        velocity=np.zeros(0),
        effort=np.array(effort, float),
    )


def bag(
    folder: Path, *messages: tuple[str, Any], topics: Sequence[str] = ("/joint_states",), kind: str = TYPE
) -> Path:
    path = folder / "bag"
    with Writer(path, version=9) as writer:
        connections = {topic: writer.add_connection(topic, kind, typestore=STORE) for topic in topics}
        for arrival, (topic, content) in enumerate(messages):
            writer.write(connections[topic], 1000 + arrival * 10**6, STORE.serialize_cdr(content, kind))
    return path


def states(stamps: Sequence[int], names: Sequence[str] = NAMES) -> list[tuple[str, Any]]:
    count = range(1, len(names) + 1)
    return [
        ("/joint_states", message(s, names, [10 * k + i for i in count], list(count))) for k, s in enumerate(stamps)
    ]


TOPICS = ("/left/joint_states", "/right/joint_states")
BOTH = [(topic, content) for _, content in states([0, 10**7]) for topic in TOPICS]
STRANGER = [*states([0, 10**7]), *states([2 * 10**7], names=("gripper",))]
FEW = [*states([2 * 10**7], names=("gripper",)), *states([0, 10**7, 3 * 10**7])]
CLOCK = [1767600000 * 10**9 + k * 4 * 10**6 for k in range(30)]
SHORT = ("/joint_states", message(0, NAMES, [1.0], [1.0, 2.0]))
RIGHT: dict[str, tuple[Sequence[tuple[str, Any]], dict[str, Any], dict[str, list[float]], list[str]]] = {
    "a joint": (states([0, 10**7]), {"names": ("b",)}, {"position_1": [2, 12]}, []),
    "an order of joints": (
        states([0, 10**7, 2 * 10**7]),
        {"names": ("b", "a")},
        {"time": [0, 0.01, 0.02], "position_1": [2, 12, 22], "position_2": [1, 11, 21]},
        [],
    ),
    "joints that messages lack": (
        [*states([0, 10**7]), *states([2 * 10**7], names=("b",))],
        {"names": NAMES},
        {"position_1": [1, 11, np.nan], "position_2": [2, 12, 1]},
        [],
    ),
    "those of another robot": (
        STRANGER,
        {"names": NAMES},
        {"position_1": [1, 11]},
        [r"1 messages of other joints (gripper) were left out"],
    ),
    "few of another robot": (
        FEW,
        {},
        {"time": [0, 0.01, 0.03], "position_2": [2, 12, 22]},
        [r"1 messages of other joints (gripper) were left out; --names"],
    ),
    "the few of another robot": (
        FEW,
        {"names": ("gripper",)},
        {"position_1": [1]},
        ["3 messages of other joints (a, b) were left out"],
    ),
    "names in another order": (
        [*states([0]), *states([10**7], names=("b", "a"))],
        {},
        {"position_1": [1, 2], "position_2": [2, 1]},
        [],
    ),
    "stamps out of order and repeated": (
        states([10**7, 0, 2 * 10**7, 2 * 10**7]),
        {},
        {"time": [0, 0.01, 0.02], "position_1": [11, 1, 21]},
        ["1 messages came out of order", "1 messages repeat the stamp"],
    ),
    "a first message before the clock": (
        states([0, *CLOCK[:3]]),
        {},
        {"time": [0, 0.004, 0.008], "position_1": [11, 21, 31]},
        ["1 messages of before the clock was set, the first is number 1, were left out"],
    ),
    "messages without a stamp in between": (
        states([*CLOCK[:2], 0, 0, CLOCK[4]]),
        {},
        {"time": [0, 0.004, 0.016], "position_1": [1, 11, 41]},
        ["2 messages of before the clock was set, the first is number 3"],
    ),
    "a computer that gets its time late": (
        states([12 * 10**9, 12 * 10**9 + 4 * 10**6, *CLOCK[2:5]]),
        {},
        {"time": [0, 0.004, 0.008], "position_1": [21, 31, 41]},
        ["2 messages of before the clock was set, the first is number 1"],
    ),
    "a simulation, first messages without a stamp": (
        states([0, 0, 100 * 10**9, 100 * 10**9 + 10**7]),
        {},
        {"time": [0, 0.01]},
        ["2 messages of before the clock was set"],
    ),
    "a simulation that begins with 0": (states([0, 10**7, 2 * 10**7]), {}, {"time": [0, 0.01, 0.02]}, []),
    "a clock that was set back": (
        states([*CLOCK[:20], *(stamp - 10**9 for stamp in CLOCK[20:])]),
        {},
        {"time": [0.004 * k for k in range(30)], "position_1": [10 * k + 1 for k in range(30)]},
        ["message 21: the clock was set back by 0.996 s; time goes on from before"],
    ),
    "no stamps": (
        states([0, 0, 0]),
        {},
        {"time": [0, 0.001, 0.002], "position_2": [2, 12, 22]},
        ["time is that of arrival"],
    ),
    "a topic": (BOTH, {"topic": TOPICS[1]}, {"position_1": [1, 11]}, []),
}
"""Messages, what is wanted of them, columns of the table, and what its notes behind the first one say."""


@pytest.mark.parametrize("name", RIGHT)
def test_messages_become_columns(name: str, tmp_path: Path) -> None:
    messages, wanted, columns, notes = RIGHT[name]
    table = read(bag(tmp_path, *messages, topics=sorted({topic for topic, _ in messages})), **wanted)
    for column, values in columns.items():
        np.testing.assert_allclose(table.column(column), values, atol=1e-12)
    assert all(expected in note for expected, note in zip(notes, table.notes[1:], strict=True)), table.notes
    assert table.options[:2] == ("--topic", wanted.get("topic", "/joint_states"))


WRONG: list[tuple[Sequence[tuple[str, Any]], dict[str, Any], dict[str, Any], str]] = [
    (BOTH, {"topics": TOPICS}, {}, r"several topics .*: /left/joint_states, /right/joint_states; choose .* --topic"),
    (
        BOTH,
        {"topics": TOPICS},
        {"topic": "/x"},
        "one of /left/joint_states, .* expected, '/x' found",
    ),
    ([], {"topics": ["/text"], "kind": "std_msgs/msg/String"}, {}, r"/text \(std_msgs/msg/String\) found; record"),
    (states([0, 1]), {}, {"names": ("b", "x")}, r"joints on /joint_states \(a, b\) expected, 'x' found"),
    (STRANGER, {}, {}, r"several sets of joints \(a,b; gripper\); choose with daq import --names a,b,c"),
    ([], {}, {}, "messages on /joint_states expected, none found"),
    ([SHORT], {}, {}, "message 1: 2 values of position, one for each name, expected, 1 found"),
]


@pytest.mark.parametrize(("messages", "content", "wanted", "reason"), WRONG)
def test_bag_without_what_is_wanted_is_refused(
    messages: Sequence[tuple[str, Any]], content: dict[str, Any], wanted: dict[str, Any], reason: str, tmp_path: Path
) -> None:
    path = bag(tmp_path, *messages, **content)
    with pytest.raises(BadInput, match=reason):
        read(path, **wanted)


def test_older_databases_hold_no_definitions(tmp_path: Path) -> None:
    """Those of ROS 2 Humble and earlier."""
    path = bag(tmp_path, *states([0, 10**7]))
    database = sqlite3.connect(next(path.glob("*.db3")))
    database.execute("DROP TABLE message_definitions")
    database.execute("UPDATE schema SET schema_version = 3")
    database.commit()
    database.close()
    np.testing.assert_array_equal(read(path).column("position_2"), [2, 12])


def test_damaged_and_misnamed_bags_are_refused(tmp_path: Path) -> None:
    path = bag(tmp_path, *states([0, 10**7]))
    database = next(path.glob("*.db3"))
    whole = database.read_bytes()
    (tmp_path / "x.bin").write_bytes(whole)
    with pytest.raises(BadInput, match=r"ends with \.db3 expected"):
        read(tmp_path / "x.bin")
    (tmp_path / "half.db3").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(BadInput, match="cannot be read as a ROS bag"):
        read(tmp_path / "half.db3")
    with pytest.raises(BadInput, match="is a recording of this program already"):
        read(Path(__file__).parents[4] / "recordings" / "samples" / "fig5a.mcap")
