"""Reading a recording, complete or interrupted, into arrays."""

import json
from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from recordings import schemas
from recordings.cdr import Layout
from recordings.config import validated
from recordings.container import DECODE_ERRORS, Batch, Container, load, open_records
from recordings.errors import BadInput, ForeignFile
from recordings.limits import parsed
from recordings.recording import CanFrames, Floats, Ints, LoggedEvent, Recording, Run
from recordings.rig import Rig

Source = Path | Recording
"""A recording, or its file."""
_SYNC_TOPICS = ("/joint_states", "/joint_commands", "/amplifiers")
_FIELDS = {
    *("header.stamp", "position", "velocity", "effort", "voltage", "statusword", "error_code", "repeat", "lateness"),
    *("value", "level", "name", "msg"),
}
"""Message fields that `read` uses, besides the joint names."""
_ALLOCATION_BYTES = 1 << 26
"""Size of one memory allocation [bytes]; the system provides only the pages in use."""
_SIGNALS = 6
"""Tables of one number a joint and SYNC."""
_SMALL_TABLES, _TABLES_BESIDE_MESSAGES = 1 << 25, 4
"""Size of the smallest recording's tables [bytes], and of others beside the messages: 1.4 where nothing but positions
was measured."""
_SMALL_BATCH = 16
"""Batches with fewer messages get an array of their own."""
_LEVELS = {number: name for name, number in schemas.LEVELS.items()}


def read(path: Path, most: int | None = None) -> Recording:
    """Read a recording; from an interrupted one, everything that is intact.

    The messages of one SYNC are joined by their stamp. Missing values are gaps: NaN; 0 in statusword and error code;
    -1 in repeat.

    Args:
        most: number of bytes of the file to read, for a preview of the beginning of a long recording.

    Raises:
        BadInput: the file is missing, not MCAP, damaged, not a recording of this program, or holds no samples.
    """
    container = _load(path, (*_SYNC_TOPICS, "/events"), _FieldSelector(), optional=("/extra",), most=most)
    run = _run(container)
    grid = _SyncGrid(container, _rig(container), _stamps(container, run))
    return Recording(
        path=path,
        rig=grid.rig,
        run=run,
        time=(grid.stamps - grid.stamps[0]) / 1e9,
        position=grid.joints("/joint_states", "position", np.nan),
        command=grid.joints("/joint_commands", "position", np.nan),
        voltage=grid.joints("/amplifiers", "voltage", np.nan),
        velocity=_unless_all_nan(grid.joints("/joint_states", "velocity", np.nan)),
        effort=_unless_all_nan(grid.joints("/joint_states", "effort", np.nan)),
        statusword=grid.joints("/amplifiers", "statusword", np.uint16(0)),
        error_code=grid.joints("/amplifiers", "error_code", np.uint16(0)),
        repeat=grid.scalars("repeat", -1),
        lateness=grid.scalars("lateness", np.nan),
        extra=grid.extra(),
        events=_events(container, int(grid.stamps[0])),
    )


def opened(source: Source) -> Recording:
    """The recording that `source` is, or that it names.

    Raises:
        BadInput: as `read`.
    """
    return source if isinstance(source, Recording) else read(source)


def is_foreign(path: Path) -> bool:
    """Return whether another program wrote this MCAP file, of which only the heads of the records are read.

    Raises:
        BadInput: the file is missing, not MCAP, or cannot be read.
    """
    with open_records(path) as stream:
        try:
            return "rig" not in stream.metadata_names()
        except DECODE_ERRORS:
            return False


def read_rig(path: Path) -> Rig:
    """Read the rig description from a recording, which need not hold samples.

    Raises:
        BadInput: the file is missing, not MCAP, damaged, or not a recording of this program.
    """
    return _rig(_load(path, (), lambda batch: batch))


def read_can(path: Path) -> CanFrames:
    """Read the CAN frames of a recording in the order in which they were logged.

    Raises:
        BadInput: the file is missing, not MCAP, damaged, or not a recording of this program.
    """
    container = _load(path, ("/can",), lambda batch: batch)
    # "tx" and "rx" have three bytes with the NUL; the empty array gives the dtype where there are no frames.
    none = np.empty(0, Layout(schemas.FIELDS["/can"], lambda *_: 3).dtype)
    batches = container.batches.get("/can", [])
    log = np.concatenate([np.empty(0, np.int64), *(batch["log"].astype(np.int64) for batch in batches)])
    order = np.argsort(log, kind="stable")
    frames = np.concatenate([none, *(batch["message"] for batch in batches)])[order]
    return CanFrames(
        stamp=_nanoseconds(frames),
        log=log[order],
        id=frames["id"].astype(np.int64),
        dlc=frames["dlc"].astype(np.int64),
        data=frames["data"],
        sent=frames["header.frame_id"] == b"tx",
        rtr=frames["is_rtr"],
        extended=frames["is_extended"],
        error=frames["is_error"],
    )


@dataclass(frozen=True)
class _SyncGrid:
    """SYNC instants of a recording, at which the messages of its topics are joined."""

    container: Container
    rig: Rig
    stamps: Ints
    """(n,) SYNC instants [ns], ascending."""

    def __post_init__(self) -> None:
        """Check that the tables are no larger than what the messages hold lets expect.

        Raises:
            BadInput: there are far more joints or further values than messages have room for.
        """
        columns = _SIGNALS * self.rig.dof + len(self._extra_names)
        if 8 * len(self.stamps) * columns > _SMALL_TABLES + _TABLES_BESIDE_MESSAGES * self.container.unpacked:
            raise BadInput(
                f"recording {self.container.path}: messages with values of {self.rig.dof} joints and "
                f"{len(self._extra_names)} further columns expected, too few found; the file was changed by another "
                "program"
            )

    def joints(self, topic: str, name: str, missing: float | np.uint16) -> NDArray[Any]:
        """One field of a topic as (n, dof), in the joint order of the rig, with `missing` and its dtype in gaps."""
        table = np.full((len(self.stamps), self.rig.dof), missing)
        for batch, rows in self._located[topic]:
            values = batch["message"][name]
            values = values.reshape(len(values), -1)  # a sequence of length one has no axis in the dtype
            if values.shape[1] == 0:  # drives need not measure velocity and effort
                continue
            if values.shape[1] != self.rig.dof:
                raise BadInput(
                    f"recording {self.container.path}: {self.rig.dof} joints expected in {name} of {topic}, "
                    f"{values.shape[1]} found; the file was changed by another program"
                )
            table[rows] = values[:, self._order(batch)]
        return table

    def scalars(self, name: str, missing: float) -> NDArray[Any]:
        """One field of /amplifiers as (n,), with `missing` in gaps."""
        table = np.full(len(self.stamps), missing)
        for batch, rows in self._located["/amplifiers"]:
            table[rows] = batch["message"][name]
        return table

    def extra(self) -> dict[str, Floats]:
        """Every value in /extra as (n,), by name; NaN in gaps."""
        columns = {name: np.full(len(self.stamps), np.nan) for name in self._extra_names}
        for batch, rows in self._located["/extra"]:
            values = batch["message"]["value"].reshape(len(batch), -1)
            for i, name in enumerate(_extra_names(batch)):
                columns[name][rows] = values[:, i]
        return columns

    @cached_property
    def _extra_names(self) -> dict[str, None]:
        """Names of the values in /extra, in the order in which they come."""
        batches = self.container.batches.get("/extra", [])
        return dict.fromkeys(name for batch in batches for name in _extra_names(batch))

    @cached_property
    def _located(self) -> dict[str, list[tuple[Batch, Ints]]]:
        """Batches by topic, each with the indices of its SYNC instants."""
        return {
            topic: [
                (batch, np.searchsorted(self.stamps, _nanoseconds(batch["message"])))
                for batch in self.container.batches.get(topic, [])
            ]
            for topic in (*_SYNC_TOPICS, "/extra")
        }

    def _order(self, batch: Batch) -> list[int]:
        """Column of each joint of the rig in the messages, by joint name if the messages contain names."""
        names = [name for name in batch["message"].dtype.names or () if name.startswith("name.")]
        if not names:
            return list(range(self.rig.dof))
        present = [set(batch["message"][name].tolist()) for name in names]
        expected = [name.encode() for name in self.rig.joint_names]
        try:
            return [present.index({name}) for name in expected]
        except ValueError:
            raise BadInput(
                f"recording {self.container.path}: joints {b', '.join(expected).decode()} expected, "
                f"{b', '.join(set().union(*present)).decode(errors='replace')} found; "
                f"the file was changed by another program"
            ) from None


def _extra_names(batch: Batch) -> list[str]:
    """Names of the values of messages in /extra."""
    first, names = batch["message"][0], batch.dtype["message"].names or ()
    return [first[name].decode(errors="replace") for name in names if name.startswith("name.")]


def _load(
    path: Path,
    topics: Collection[str],
    condense: Callable[[Batch], Batch],
    optional: Collection[str] = (),
    most: int | None = None,
) -> Container:
    container = load(path, (*topics, *optional), condense, most)
    lacking = [name for name in ("rig", "run") if name not in container.metadata]
    lacking += [topic for topic in topics if topic not in container.fields]
    if lacking and container.cut_off:
        raise BadInput(f"recording {path} was cut off before its first data; record again")
    if lacking:
        raise ForeignFile(
            f"{path} is not a recording of this program: metadata records 'rig' and 'run' and the topics "
            f"{', '.join(topics)} expected, {', '.join(lacking)} not found",
            path,
        )
    _check_layout(container)
    return container


class _FieldSelector:
    """Copies only the message fields that `read` uses, because all messages of an hour would fill the memory.

    The copies share a few large allocations; many small ones, once freed, would not return to the system.
    """

    def __init__(self) -> None:
        self._pieces: dict[np.dtype[Any], Batch] = {}

    def __call__(self, batch: Batch) -> Batch:
        names = [name for name in batch["message"].dtype.names or () if name in _FIELDS or name.startswith("name.")]
        if not names:  # messages of another program; `_check_layout` reports them
            return batch
        message = batch["message"][names]
        slim = self._allocate(
            len(batch), np.dtype([("log", "<u8"), ("message", [(name, message.dtype[name]) for name in names])])
        )
        slim["log"], slim["message"] = batch["log"], message
        return slim

    def _allocate(self, count: int, kind: np.dtype[Any]) -> Batch:
        if count < _SMALL_BATCH:
            return np.empty(count, kind)
        piece = self._pieces.get(kind)
        if piece is None or len(piece) < count:
            piece = np.empty(max(count, _ALLOCATION_BYTES // kind.itemsize), kind)
        self._pieces[kind] = piece[count:]
        return piece[:count]


def _check_layout(container: Container) -> None:
    layout = container.metadata["rig"].get("layout")
    if layout != schemas.LAYOUT:
        raise BadInput(
            f"recording {container.path}: layout {schemas.LAYOUT} expected, {layout} found; "
            f"read it with the program that wrote it ({container.metadata['run'].get('software')}) or a newer one"
        )
    for topic, fields in container.fields.items():
        lacking = [field.name for field in schemas.FIELDS[topic] if field not in fields]
        if lacking:
            raise BadInput(
                f"recording {container.path}: messages of {topic} with {', '.join(lacking)} expected, none found; "
                f"the file was changed by another program"
            )


def _rig(container: Container) -> Rig:
    where = f"recording {container.path}: metadata record 'rig'"
    content = parsed(json.loads, container.metadata["rig"].get("json", ""), where, "JSON")
    return validated(content, Rig, where)


def _run(container: Container) -> Run:
    try:
        return Run.model_validate_strings(container.metadata["run"])
    except ValidationError as error:
        first = error.errors()[0]
        raise BadInput(
            f"recording {container.path}: metadata record 'run': {first['loc'][0]}: {first['msg']}; "
            f"the file was changed by another program"
        ) from None


def _stamps(container: Container, run: Run) -> Ints:
    batches = [batch for topic in _SYNC_TOPICS for batch in container.batches.get(topic, [])]
    if not batches:
        reason = run.reason or "it was interrupted"
        raise BadInput(
            f"recording {container.path} holds no samples, the run ended before: {reason}; record again, or if it "
            "was made by listening, `daq recover` makes them of its frames"
        )
    # Each topic is in order already, which a stable sort makes use of, other than np.unique.
    stamps = np.sort(np.concatenate([_nanoseconds(batch["message"]) for batch in batches]), kind="stable")
    return stamps[np.diff(stamps, prepend=stamps[:1] - 1) > 0]


def _nanoseconds(messages: Batch) -> Ints:
    stamp = messages["header.stamp"]
    nanoseconds: Ints = stamp["sec"].astype(np.int64) * 10**9 + stamp["nanosec"]
    return nanoseconds


def _unless_all_nan(table: Floats) -> Floats | None:
    return None if np.isnan(table).all() else table


def _events(container: Container, first_stamp: int) -> tuple[LoggedEvent, ...]:
    events = []
    for batch in container.batches.get("/events", []):
        for log, message in zip(batch["log"].tolist(), batch["message"], strict=True):
            level = _LEVELS.get(int(message["level"]), "info")
            source, text = (message[name].decode(errors="replace") for name in ("name", "msg"))
            events.append(LoggedEvent((log - first_stamp) / 1e9, level, source, text))
    return tuple(sorted(events, key=lambda event: event.time))
