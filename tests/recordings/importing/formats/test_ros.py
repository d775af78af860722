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
from recordings.importing import formats
from recordings.importing.table import BagPart, Table

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


def read(path: Path, topic: str | None = None, names: tuple[str, ...] = ()) -> Table:
    return formats.read(path, BagPart(topic, names))


def test_names_choose_the_joints_and_their_order(tmp_path: Path) -> None:
    path = bag(tmp_path, *states([0, 10**7, 2 * 10**7]))
    np.testing.assert_array_equal(read(path, names=("b",)).column("position_1"), [2, 12, 22])
    both = read(path, names=("b", "a"))
    np.testing.assert_array_equal(both.column("position_2"), [1, 11, 21])
    np.testing.assert_array_equal(both.column("time"), [0, 0.01, 0.02])
    assert both.options == ("--topic", "/joint_states", "--names", "b,a")


def test_joints_that_messages_lack_are_gaps(tmp_path: Path) -> None:
    path = bag(tmp_path, *states([0, 10**7]), *states([2 * 10**7], names=("gripper",)))
    with pytest.raises(BadInput, match=r"several sets of joints \(a,b; gripper\); choose with --names"):
        read(path)
    np.testing.assert_array_equal(read(path, names=NAMES).column("position_1"), [1, 11, np.nan])


def test_order_of_names_may_change(tmp_path: Path) -> None:
    path = bag(tmp_path, *states([0]), *states([10**7], names=("b", "a")))
    np.testing.assert_array_equal(read(path).column("position_1"), [1, 2])


def test_unsorted_and_repeated_stamps_are_noted(tmp_path: Path) -> None:
    table = read(bag(tmp_path, *states([10**7, 0, 2 * 10**7, 2 * 10**7])))
    np.testing.assert_array_equal(table.column("time"), [0, 0.01, 0.02])
    np.testing.assert_array_equal(table.column("position_1"), [11, 1, 21])
    assert "1 messages came out of order" in table.notes[1]
    assert "1 messages repeat the stamp" in table.notes[2]


def test_arrival_is_time_where_the_stamps_are_empty(tmp_path: Path) -> None:
    table = read(bag(tmp_path, *states([0, 0, 0])))
    np.testing.assert_allclose(table.column("time"), [0, 0.001, 0.002])
    assert "time is that of arrival" in table.notes[1]


TOPICS = ("/left/joint_states", "/right/joint_states")
BOTH = [(topic, content) for _, content in states([0, 10**7]) for topic in TOPICS]
SHORT = ("/joint_states", message(0, NAMES, [1.0], [1.0, 2.0]))
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


def test_topic_is_chosen(tmp_path: Path) -> None:
    assert read(bag(tmp_path, *BOTH, topics=TOPICS), TOPICS[1]).count == 2


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
    (path / "metadata.yaml").write_text("nonsense: [")
    with pytest.raises(BadInput, match="cannot be read as a ROS bag"):
        read(path)
    with pytest.raises(BadInput, match="is a recording of this program already"):
        read(Path(__file__).parents[4] / "recordings" / "samples" / "fig5a.mcap")
