"""The messages of a recording, joined by the stamp of their SYNC."""

import json
from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from recordings import schemas
from recordings.config import validated
from recordings.container import Batch, Container
from recordings.errors import BadInput, ForeignFile
from recordings.limits import parsed
from recordings.recording import Floats, Ints, LoggedEvent, Recording, Run
from recordings.rig import Rig

SYNC_TOPICS = ("/joint_states", "/joint_commands", "/amplifiers")
_SIGNALS = 6
"""Tables of one number a joint and SYNC."""
_SMALL_TABLES, _TABLES_BESIDE_MESSAGES = 1 << 25, 4
"""Size of the smallest recording's tables [bytes], and of others beside the messages: 1.4 where nothing but positions
was measured."""
_LEVELS = {number: name for name, number in schemas.LEVELS.items()}


@dataclass(frozen=True)
class SyncGrid:
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

    def recording(self, run: Run, start: int) -> Recording:
        """The samples as a recording, whose time counts from `start` [ns]."""
        return Recording(
            path=self.container.path,
            rig=self.rig,
            run=run,
            time=(self.stamps - start) / 1e9,
            position=self.joints("/joint_states", "position", np.nan),
            command=self.joints("/joint_commands", "position", np.nan),
            voltage=self.joints("/amplifiers", "voltage", np.nan),
            velocity=_unless_all_nan(self.joints("/joint_states", "velocity", np.nan)),
            effort=_unless_all_nan(self.joints("/joint_states", "effort", np.nan)),
            statusword=self.joints("/amplifiers", "statusword", np.uint16(0)),
            error_code=self.joints("/amplifiers", "error_code", np.uint16(0)),
            repeat=self.scalars("repeat", -1),
            lateness=self.scalars("lateness", np.nan),
            extra=self.extra(),
            events=_events(self.container, start),
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
                (batch, np.searchsorted(self.stamps, nanoseconds(batch["message"])))
                for batch in self.container.batches.get(topic, [])
            ]
            for topic in (*SYNC_TOPICS, "/extra")
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


def check_container(container: Container, topics: Collection[str]) -> Container:
    """Return the `container`, if it is a recording with these `topics`.

    Raises:
        BadInput: it is not, or was cut off before its data.
    """
    path = container.path
    lacking = [name for name in ("rig", "run") if name not in container.metadata]
    lacking += [topic for topic in topics if topic not in container.fields]
    if lacking and container.cut_off:
        found = f"recording {path} was cut off before its first data"
        raise BadInput(f"{found}; record again") if "rig" in container.metadata else ForeignFile(found, path)
    if lacking:
        raise ForeignFile(
            f"{path} is not a recording of this program: metadata records 'rig' and 'run' and the topics "
            f"{', '.join(topics)} expected, {', '.join(lacking)} not found",
            path,
        )
    layout = container.metadata["rig"].get("layout")
    if layout != schemas.LAYOUT:
        raise BadInput(
            f"recording {path}: layout {schemas.LAYOUT} expected, {layout} found; "
            f"read it with the program that wrote it ({container.metadata['run'].get('software')}) or a newer one"
        )
    for topic, fields in container.fields.items():
        lacking = [field.name for field in schemas.FIELDS[topic] if field not in fields]
        if lacking:
            raise BadInput(
                f"recording {path}: messages of {topic} with {', '.join(lacking)} expected, none found; "
                f"the file was changed by another program"
            )
    return container


def rig_of(container: Container) -> Rig:
    """The rig description. Raises BadInput where it is damaged."""
    where = f"recording {container.path}: metadata record 'rig'"
    content = parsed(json.loads, container.metadata["rig"].get("json", ""), where, "JSON")
    return validated(content, Rig, where)


def run_of(container: Container) -> Run:
    """The description of the run. Raises BadInput where it is damaged."""
    try:
        return Run.model_validate_strings(container.metadata["run"])
    except ValidationError as error:
        first = error.errors()[0]
        raise BadInput(
            f"recording {container.path}: metadata record 'run': {first['loc'][0]}: {first['msg']}; "
            f"the file was changed by another program"
        ) from None


def sync_stamps(container: Container, run: Run) -> Ints:
    """(n,) SYNC instants [ns], ascending. Raises BadInput where there is no sample."""
    batches = [batch for topic in SYNC_TOPICS for batch in container.batches.get(topic, [])]
    if not batches:
        reason = run.reason or "it was interrupted"
        raise BadInput(
            f"recording {container.path} holds no samples, the run ended before: {reason}; record again, or if it "
            "was made by listening, `daq recover` makes them of its frames"
        )
    # Each topic is in order already, which a stable sort makes use of, other than np.unique.
    stamps = np.sort(np.concatenate([nanoseconds(batch["message"]) for batch in batches]), kind="stable")
    return stamps[np.diff(stamps, prepend=stamps[:1] - 1) > 0]


def nanoseconds(messages: Batch) -> Ints:
    """(n,) stamps of messages [ns]."""
    stamp = messages["header.stamp"]
    return stamp["sec"].astype(np.int64) * 10**9 + stamp["nanosec"]


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
