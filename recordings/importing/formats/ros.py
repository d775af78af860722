"""Messages sensor_msgs/JointState of ROS 2 bags (MCAP or SQLite, alone or as a folder) and ROS 1 bags, by rosbags.

The columns are `time`, `position_i`, `velocity_i` and `effort_i`, where i numbers the joints.
"""

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Chunk
from zstandard import ZstdDecompressor

from recordings.chunk import unpacked
from recordings.container import decode, open_records
from recordings.errors import BadInput, told
from recordings.importing.formats import reading
from recordings.importing.table import Table
from recordings.limits import Allowance
from recordings.recording import Floats, Ints
from recordings.recovery import rewrite

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader

_TYPE = "sensor_msgs/msg/JointState"
_RECORDED_TYPE = "delta_msgs/msg/AmplifierState"
"""Message type that only recordings of this program hold."""
_FIELDS = ("position", "velocity", "effort")
_CLOCK = 946_684_800 * 10**9
"""Time of a clock that was set, at least [ns]: the year 2000."""
_LATE = 10
"""Number of messages in a row that are those of a clock that was set back, and not late ones."""
_MAGIC = (b"\x89MCAP0", b"SQLite format 3\0", b"#ROSBAG V2.0")
_SUFFIXES = dict(zip(_MAGIC, (".mcap", ".db3", ".bag"), strict=True))


def recognises(path: Path, head: bytes) -> bool:
    """See `ImportFormat`."""
    if path.is_dir():
        return (path / "metadata.yaml").exists() or bool(_files(path))
    return head.startswith(_MAGIC)


def read(path: Path, wanted: str | None = None, names: tuple[str, ...] = ()) -> Table:
    """See `ImportFormat`.

    wanted: topic; None: the only one that fits.
    names: joints in the order in which they are numbered; empty: all, in the order of the file.
    """
    _check_suffix(path)
    with reading(path, "a ROS bag", "check that it is complete"), TemporaryDirectory() as folder:
        files, damages = _intact(path, Path(folder))
        with _opened(files) as bag:
            topic = _topic(path, bag, wanted)
            messages = list(_messages(bag, topic))
    if not messages:
        raise BadInput(f"{path}: messages on {topic} expected, none found; choose another {_importing('--topic')}")
    table = _table(path, topic, messages, names)
    return replace(table, notes=(*table.notes, *damages))


def _opened(files: list[Path]) -> "AnyReader":
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    # Bags of ROS 2 Humble and earlier do not hold the definitions of their messages.
    return AnyReader(files, default_typestore=get_typestore(Stores.ROS2_HUMBLE))


def _files(path: Path) -> list[Path]:
    """Files in a folder that may hold messages of a bag."""
    return sorted(file for file in path.iterdir() if file.suffix in _SUFFIXES.values())


def _intact(path: Path, folder: Path) -> tuple[list[Path], list[str]]:
    """The bag; of a damaged one its files, those of MCAP anew in `folder` with what is intact, and what is lost."""
    try:
        _check_size(path)
        with _opened([path]) as bag:
            if bag.connections:  # the summary of an MCAP file may lack them
                return [path], []
    except Exception:  # of the library, which has one for every kind of damage
        pass
    files, damages = [path], []
    if path.is_dir() and (found := _files(path)):
        files, damages = found, [f"{path.name}: the files in it were read, without metadata.yaml"]
    if len({re.sub(r"_\d+$", "", file.stem) for file in files}) > 1:
        listed = ", ".join(file.name for file in files)
        raise BadInput(f"{path}: metadata.yaml, or the files of one bag, expected, {listed} found; name one of them")
    for file in [file for file in files if file.suffix == ".mcap"]:
        files.remove(file)
        try:
            kept = rewrite(file, folder / file.name, {})
        except BadInput as error:
            damages.append(f"left out: {error}")
            continue
        files.append(folder / file.name)
        intact = f"{kept.messages} messages of {kept.duration:.3f} s are intact"
        damages += [] if kept.whole else [f"{file.name} is cut off or damaged: {intact}, lost are {kept.loss}"]
    if not files:
        raise BadInput(damages[-1].removeprefix("left out: "))
    for file in files:  # what is too large stays so
        _check_size(file)
    return files, damages


def _check_suffix(path: Path) -> None:
    """Check that the name of a file says what it is: rosbags goes by it."""
    if path.is_dir():
        return
    with path.open("rb") as stream:
        head = stream.read(max(map(len, _MAGIC)))
    expected = next(suffix for magic, suffix in _SUFFIXES.items() if head.startswith(magic))
    if path.suffix != expected:
        raise BadInput(f"{path}: a name that ends with {expected} expected for such a bag; rename it")


def _check_size(path: Path) -> None:
    """Unpack what rosbags would unpack at once, to see how large it becomes, and that it is whole.

    Raises an error of any kind.
    """
    allowance, opcode = Allowance(), 0
    for file in path.iterdir() if path.is_dir() else [path]:
        if file.suffix == ".mcap":
            with open_records(file) as stream:
                for opcode, _, body in stream.records():
                    if opcode == Opcode.CHUNK:
                        unpacked(decode(Chunk.read, body), allowance)
            if opcode != Opcode.FOOTER:
                raise ValueError("its records do not lead to its end")
        elif file.suffix == ".zstd":
            allowance.take(0, file.stat().st_size)
            with file.open("rb") as packed:
                for block in ZstdDecompressor().read_to_iter(packed):
                    allowance.take(len(block))


def _importing(option: str) -> str:
    """An option of `daq import`, which has no counterpart in Python."""
    return told(option, f"daq import {option}")


def _topic(path: Path, bag: "AnyReader", wanted: str | None) -> str:
    if any(connection.msgtype == _RECORDED_TYPE for connection in bag.connections):
        raise BadInput(f"{path} is a recording of this program already; give it to ident as it is")
    topics = sorted({connection.topic for connection in bag.connections if connection.msgtype == _TYPE})
    if wanted in topics:
        return wanted
    listed = ", ".join(topics)
    if wanted is not None:
        raise BadInput(f"{path}: --topic: one of {listed or 'no topics'} expected, {wanted!r} found; choose one")
    if not topics:
        others = ", ".join(sorted({f"{c.topic} ({c.msgtype})" for c in bag.connections})) or "no topics"
        raise BadInput(f"{path}: a topic of {_TYPE} expected, {others} found; record the joint states")
    if len(topics) > 1:
        raise BadInput(f"{path}: several topics of {_TYPE} found: {listed}; choose one with {_importing('--topic')}")
    return topics[0]


class _Message(NamedTuple):
    number: int
    """Its place on the topic, from 1."""
    stamp: int
    """Of the header [ns]."""
    arrival: int
    """[ns]."""
    names: tuple[str, ...]
    fields: tuple[Floats, ...]
    """Those of `_FIELDS`, each empty or one number per name."""


def _messages(bag: "AnyReader", topic: str) -> Iterator[_Message]:
    """Messages of `topic` in the order in which they were recorded."""
    connections = [connection for connection in bag.connections if connection.topic == topic]
    kept: dict[tuple[str, ...], tuple[str, ...]] = {}
    for number, (connection, arrival, raw) in enumerate(bag.messages(connections=connections), start=1):
        message: Any = bag.deserialize(raw, connection.msgtype)
        names, stamp = tuple(message.name), message.header.stamp
        fields = tuple(getattr(message, field) for field in _FIELDS)
        # Equal names share their memory: there may be millions of messages.
        yield _Message(number, stamp.sec * 10**9 + stamp.nanosec, arrival, kept.setdefault(names, names), fields)


def _table(path: Path, topic: str, messages: list[_Message], names: tuple[str, ...]) -> Table:
    joints = _joints(path, topic, messages, names)
    strange = {names for names in {message.names for message in messages} if names and not {*names} & {*joints}}
    count, messages = len(messages), [message for message in messages if message.names not in strange]
    stamps, kept, notes = _order(messages)
    if strange:
        listed = ", ".join(sorted(set().union(*strange)))
        notes.append(f"{count - len(messages)} messages of other joints ({listed}) were left out; --names chooses")
    values = {field: _values(path, messages, joints, number)[kept] for number, field in enumerate(_FIELDS)}
    columns = {
        f"{field}_{joint}": column
        for field, table in values.items()
        for joint, column in enumerate(table.T, start=1)
        if np.isfinite(table).any()
    }
    numbered = ", ".join(f"{number} = {name}" for number, name in enumerate(joints, start=1))
    return Table(
        path,
        {"time": (stamps - stamps[0]) / 1e9, **columns},
        start=datetime.fromtimestamp(int(stamps[0]) / 1e9, UTC).isoformat(timespec="milliseconds"),
        notes=(f"topic {topic}, joints: {numbered}", *notes),
        options=("--topic", topic, *(("--names", ",".join(joints)) if messages[0].names else ())),
    )


def _joints(path: Path, topic: str, messages: list[_Message], names: tuple[str, ...]) -> tuple[str, ...]:
    """Names of the joints: those that are wanted, each of which is in some message, or those of nearly all messages,
    where the others are of other ones; numbers where they have no names."""
    sets = Counter(frozenset(message.names) for message in messages)
    (most, count), *others = sets.most_common()
    present = frozenset[str]().union(*sets)
    if unknown := [name for name in names if name not in present]:
        listed = ", ".join(sorted(present)) or "without names"
        raise BadInput(f"{path}: --names: joints on {topic} ({listed}) expected, {unknown[0]!r} found; correct it")
    if not names and others and (any(most & other for other, _ in others) or 2 * (len(messages) - count) >= count):
        listed = "; ".join(sorted(",".join(sorted(names)) for names in sets))
        raise BadInput(
            f"{path}: {topic} carries several sets of joints ({listed}); choose with {_importing('--names a,b,c')}"
        )
    first = next(message for message in messages if {*message.names} == most)
    return names or first.names or tuple(f"joint_{i + 1}" for i in range(len(first.fields[0])))


def _order(messages: list[_Message]) -> tuple[Ints, Ints, list[str]]:
    """Stamps (n,) [ns] in ascending order, the messages they belong to (n,), and what was done for that."""
    notes = []
    stamps = np.array([message.stamp for message in messages])
    if len(np.unique(stamps)) < 2 <= len(stamps):
        stamps = np.array([message.arrival for message in messages])
        notes.append("the stamps of the messages are all the same: time is that of arrival, which jitters more")
    rows = np.flatnonzero(stamps >= (_CLOCK if stamps.max() >= _CLOCK else 1))
    unset = np.setdiff1d(np.arange(len(stamps)), rows)
    if len(unset) and len(rows) and 0 < np.ptp(stamps[rows]) < stamps[rows].min():
        first = messages[unset[0]].number
        notes.append(f"{len(unset)} messages of before the clock was set, the first is number {first}, were left out")
    else:  # a clock that began with 0, as that of a simulation
        rows = np.arange(len(stamps))
    stamps = stamps[rows]
    for row in np.flatnonzero(np.diff(stamps) < 0) + 1:
        if len(later := stamps[row : row + _LATE]) == _LATE and later.max() < stamps[row - 1]:
            back, number = stamps[row - 1] - stamps[row], messages[rows[row]].number
            stamps[row:] += back + int(np.median(np.diff(stamps)))
            notes.append(f"message {number}: the clock was set back by {back / 1e9:g} s; time goes on from before")
    if late := int((np.diff(stamps) < 0).sum()):
        notes.append(f"{late} messages came out of order and were sorted by their stamps")
    unique, kept = np.unique(stamps, return_index=True)
    if len(unique) < len(rows):
        notes.append(f"{len(rows) - len(unique)} messages repeat the stamp of an earlier one and were left out")
    return unique, rows[kept], notes


def _values(path: Path, messages: list[_Message], joints: tuple[str, ...], field: int) -> Floats:
    """Values (n, dof) of a field, given by its place in `_FIELDS`; NaN where a message lacks a joint."""
    table = np.full((len(messages), len(joints)), np.nan)
    layouts: dict[tuple[str, ...], tuple[Ints, Ints]] = {}
    for row, message in enumerate(messages):
        names, content = message.names, message.fields[field]
        if names not in layouts:
            layouts[names] = _layout(names, joints)
        here, there = layouts[names]
        if len(content) and len(names) not in (0, len(content)):
            raise BadInput(
                f"{path}: message {message.number}: {len(names)} values of {_FIELDS[field]}, one for each name, "
                f"expected, {len(content)} found; choose another {_importing('--topic')}"
            )
        if len(content) > there.max(initial=-1):
            table[row, here] = content[there]
    return table


def _layout(names: tuple[str, ...], joints: tuple[str, ...]) -> tuple[Ints, Ints]:
    """Which joints (k,) a message names, and where they stand in it (k,)."""
    if not names:
        return np.arange(len(joints)), np.arange(len(joints))
    places = [(k, names.index(joint)) for k, joint in enumerate(joints) if joint in names]
    here, there = np.array(places, dtype=np.int64).reshape(-1, 2).T
    return here, there
