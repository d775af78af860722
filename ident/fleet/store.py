"""The store of a fleet: Parquet files with one row per recording, parameter, effect and error.

`STORE/recordings/ROBOT/YYYY-MM.parquet` together are one table. A recording that is done is a file of its own, until
the run settles what is new: in one step all of it is one file, and then what it holds is put where it belongs, which
can be repeated. So a crash loses at most the recordings in work. A file appears whole or not at all.
The columns are described in docs/how-to/watch-a-fleet.md.
"""

import errno
import os
from collections import defaultdict
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from urllib.parse import quote

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from ident.fleet.places import content, make_folder, one_writer, whole
from ident.fleet.recording_rows import Row
from ident.fleet.walk import FileState
from recordings.errors import BadInput

SCHEMA = pa.schema(
    [
        ("key", pa.string()),  # SHA-256 of content, settings and method: the identity of a recording's rows
        ("settings", pa.string()),  # digest of settings and method
        ("content", pa.string()),  # SHA-256 of the file
        ("path", pa.string()),
        ("size", pa.int64()),  # [bytes]
        ("changed", pa.int64()),  # time of the file's last change [ns]
        ("robot", pa.string()),
        ("start", pa.timestamp("us", tz="UTC")),
        ("simulated", pa.bool_()),
        ("seconds", pa.float64()),  # duration
        ("motion", pa.list_(pa.float64())),  # numbers by which the same motion is recognised
        ("temperature", pa.float64()),  # [degC] of the joint's drive, or the mean of all; null: not measured
        ("kind", pa.string()),  # recording, parameter, effect, error, floor
        ("status", pa.string()),  # done, failed
        ("reason", pa.string()),  # why it failed
        ("name", pa.string()),
        ("joint", pa.int16()),  # from 1; null: of the whole robot
        ("value", pa.float64()),
        ("unit", pa.string()),
        ("low", pa.float64()),  # 95 % interval, for an exactly known torque gain
        ("high", pa.float64()),
        ("motion_number", pa.int64()),  # of the robot's motions, from 0
        ("common", pa.float64()),  # what the other robots did, relative; null: too few, or not needed
    ],
    metadata={"schema": "2"},
)
_OF_FILE = SCHEMA.names[: SCHEMA.get_field_index("simulated") + 1]
INDEX = pa.schema([SCHEMA.field(name) for name in (*_OF_FILE, "kind", "status", "reason")])
"""Columns of `STORE/index.parquet`, with one row per recording: what a night has to know of all of them."""
_SINGLE = "one-"
_AT_ONCE = 2000
"""Recordings that are settled at once: as many rows are in the memory."""


class Store:
    """A folder of results; `locked` before anything is written."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._table = folder / "recordings"

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Create the store where there is none, and keep other runs away from it.

        Raises:
            BadInput: another run uses the store, it cannot be written, or the folder holds something else.
        """
        others = [path.name for path in self.folder.iterdir()] if self.folder.is_dir() else []
        if others and not self._table.is_dir() and others != [".lock"]:
            raise BadInput(f"{self.folder}: a store or an empty folder expected, '{others[0]}' found; name another")
        with one_writer(self.folder):
            make_folder(self._table)
            yield

    def add(self, rows: Sequence[Row]) -> None:
        """Keep the rows of one recording.

        Raises:
            BadInput: the disk is full, or the store cannot be written; what it holds stays usable.
        """
        self._write(pa.Table.from_pylist(list(rows), SCHEMA), self._table / f"{_SINGLE}{rows[0]['key']}.parquet")

    def table(self) -> pa.Table:
        """All rows, sorted by key; each recording once.

        Raises:
            BadInput: there is no store, or one of its files is damaged.
        """
        return _sorted(self._each_once(self._files(), SCHEMA))

    def index(self) -> pa.Table:
        """One row per recording, with the columns of INDEX.

        Raises:
            BadInput: there is no store, or one of its files is damaged.
        """
        return self._each_once([*_existing(self._index), *self._unsettled()], INDEX)

    def rows_of(self, robot: str, settings: str, since: datetime | None = None) -> pa.Table:
        """All settled rows of a `robot` with this digest of `settings`, `since` the begin of a month or the first."""
        month = f"{since:%Y-%m}" if since else ""
        paths = [path for path in sorted(self._folder_of(robot).glob("*.parquet")) if path.stem >= month]
        table = self._each_once(paths, SCHEMA)
        return table.filter(pc.and_(pc.equal(table["settings"], settings), pc.equal(table["robot"], robot)))

    def new(self) -> Iterator[list[Path]]:
        """Files of recordings that are not settled, some at a time in the order of time."""
        starts = []
        for path in self._table.glob(f"{_SINGLE}*.parquet"):
            start = self._read(path, INDEX)["start"][0].as_py()
            starts.append((start.timestamp() if start else 0.0, path.name))
        ordered = [self._table / name for _, name in sorted(starts)]
        yield from (ordered[first : first + _AT_ONCE] for first in range(0, len(ordered), _AT_ONCE))

    def read(self, paths: Sequence[Path]) -> list[Row]:
        """All rows of these files, in their order."""
        return [row for path in paths for row in self._read(path, SCHEMA).to_pylist()]

    def settle(self, rows: Sequence[Row], paths: Sequence[Path]) -> None:
        """Keep `rows` in place of the files `paths`, which hold them as they were, in one step or not at all."""
        self._write(pa.Table.from_pylist(list(rows), SCHEMA), self._settled)
        self._remove(paths)

    def settled(self) -> list[Row]:
        """Rows that are settled, but not where they belong."""
        return self.read([self._settled]) if self._settled.exists() else []

    def put_away(self, rows: Sequence[Row]) -> None:
        """Put the settled `rows` where they belong; what is there already stays."""
        places: dict[Path, list[Row]] = defaultdict(list)
        for row in rows:
            places[self._place(row)].append(row)
        for path, of_place in places.items():
            self._merge(path, pa.Table.from_pylist(of_place, SCHEMA))
        recordings = [row for row in rows if row["kind"] == "recording"]
        self._merge(self._index, pa.Table.from_pylist(recordings, INDEX))
        # What was cut off before these were removed would be settled twice.
        self._remove([self._table / f"{_SINGLE}{row['key']}.parquet" for row in recordings])
        self._remove([self._settled])

    def index_anew(self) -> None:
        """Make the index from all rows."""
        self._write(self._each_once(sorted(self._table.glob("*/*.parquet")), INDEX), self._index)

    @property
    def _settled(self) -> Path:
        return self._table / "settled.parquet"

    @property
    def _index(self) -> Path:
        return self.folder / "index.parquet"

    def _folder_of(self, robot: str | None) -> Path:
        return self._table / file_name(robot or "-")

    def _place(self, row: Row) -> Path:
        month = f"{row['start']:%Y-%m}" if row["start"] else "undated"
        return self._folder_of(row["robot"]) / f"{month}.parquet"

    def _unsettled(self) -> list[Path]:
        """The settled file goes first: its rows count."""
        return [*_existing(self._settled), *sorted(self._table.glob(f"{_SINGLE}*.parquet"))]

    def _files(self) -> list[Path]:
        return [*sorted(self._table.glob("*/*.parquet")), *self._unsettled()]

    def _each_once(self, paths: Sequence[Path], schema: pa.Schema) -> pa.Table:
        """Rows of these files; of a recording that several have, those of the first: a crash leaves it twice."""
        if not self._table.is_dir():
            raise BadInput(f"{self.folder}: a store of `ident fleet` expected, none found; check the path")
        tables, seen = [schema.empty_table()], set[str]()
        for path in paths:
            table = self._read(path, schema)
            keys = set(pc.unique(table["key"]).to_pylist())
            if repeated := keys & seen:
                table = _without(table, repeated)
            seen |= keys
            tables.append(table)
        return pa.concat_tables(tables)

    def _merge(self, path: Path, table: pa.Table) -> None:
        """Add the rows of a `table` to a file, but for recordings that it has."""
        if path.exists():
            known = self._read(path, table.schema)
            table = pa.concat_tables([known, _without(table, known["key"].to_pylist())])
        self._write(table, path)

    def _remove(self, paths: Sequence[Path]) -> None:
        for path in paths:
            path.unlink(missing_ok=True)

    def known_contents(self, table: pa.Table) -> dict[FileState, str]:
        """SHA-256 of files by their state, of all recordings in `table`."""
        columns = (table[name].to_pylist() for name in ("path", "size", "changed", "content"))
        return {(path, size, changed): content for path, size, changed, content in zip(*columns, strict=True)}

    def _read(self, path: Path, schema: pa.Schema) -> pa.Table:
        try:
            recordings = [("kind", "=", "recording")] if schema is INDEX else None
            return pq.read_table(content(path), schema=schema, filters=recordings)
        except (OSError, pa.ArrowException) as error:
            raise BadInput(
                f"{path} is damaged ({' '.join(str(error).split())[:80]}); remove it, then "
                f"`ident fleet rebuild --store {self.folder}`, and run `ident fleet` again"
            ) from None

    def _write(self, table: pa.Table, path: Path) -> None:
        try:
            with whole(path) as partial:
                pq.write_table(table, partial, compression="zstd")
                _flush(partial)
        except OSError as error:
            reason = "the disk is full" if error.errno == errno.ENOSPC else error.strerror
            raise BadInput(
                f"store {self.folder} cannot be written: {reason}; what it holds is kept. Make room and run again"
            ) from None


def file_name(robot: str) -> str:
    """A name of files of this `robot`, which may have any."""
    return quote(robot, safe=" ").replace(".", "%2E")


def _existing(path: Path) -> list[Path]:
    return [path] if path.exists() else []


def _sorted(table: pa.Table) -> pa.Table:
    return table.take(pc.sort_indices(table, [("key", "ascending"), ("kind", "descending"), ("name", "ascending")]))


def _without(table: pa.Table, keys: Collection[str]) -> pa.Table:
    return table.filter(pc.invert(pc.is_in(table["key"], pa.array(list(keys), pa.string()))))


def _flush(path: Path) -> None:
    """Wait until the file's content is on the disk, before it gets its name."""
    with path.open("rb") as stream:
        os.fsync(stream.fileno())
