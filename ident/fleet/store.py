"""The store of a fleet: Parquet files with one row per recording, parameter, effect and error.

`STORE/recordings/*.parquet` together are one table; a recording that is done is a file of its own until files are
joined, so that a crash loses at most the recordings in work. A file appears whole or not at all.
The columns are described in docs/how-to/watch-a-fleet.md.
"""

import errno
import fcntl
import hashlib
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from ident.fleet.recording_rows import Row
from ident.fleet.walk import FileState
from recordings.errors import BadInput
from recordings.files import replacement

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
    ],
    metadata={"schema": "1"},
)
JOINED = 500
"""Number of files of single recordings from which they are joined into one."""
_SINGLE, _MANY = "one-", "many-"


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
        try:
            self._table.mkdir(parents=True, exist_ok=True)
            stream = (self.folder / ".lock").open("w")
        except OSError as error:
            raise BadInput(f"store {self.folder} cannot be written: {error.strerror}; choose another place") from None
        with stream:
            try:
                fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise BadInput(
                    f"store {self.folder} is in use by another `ident fleet`; wait until it ends"
                ) from None
            yield

    def add(self, rows: Sequence[Row]) -> None:
        """Keep the rows of one recording.

        Raises:
            BadInput: the disk is full, or the store cannot be written; what it holds stays usable.
        """
        self._write(pa.Table.from_pylist(list(rows), SCHEMA), f"{_SINGLE}{rows[0]['key']}.parquet")

    def table(self) -> pa.Table:
        """All rows, sorted by key; each recording once.

        Raises:
            BadInput: there is no store, or one of its files is damaged.
        """
        if not self._table.is_dir():
            raise BadInput(f"{self.folder}: a store of `ident fleet` expected, none found; check the path")
        tables, seen = [], set[str]()
        for path in sorted(self._table.glob("*.parquet")):
            table = self._read(path)
            keys = set(table["key"].to_pylist())
            # A crash between joining files and removing them leaves recordings twice.
            if repeated := keys & seen:
                mask = pa.array([key not in repeated for key in table["key"].to_pylist()], pa.bool_())
                table = table.filter(mask)
            seen |= keys
            tables.append(table)
        joined = pa.concat_tables(tables) if tables else SCHEMA.empty_table()
        return joined.take(
            pc.sort_indices(joined, [("key", "ascending"), ("kind", "descending"), ("name", "ascending")])
        )

    def join(self, least: int = JOINED) -> None:
        """Join the files of single recordings into one, if there are at least so many."""
        single = sorted(self._table.glob(f"{_SINGLE}*.parquet"))
        if len(single) < least:
            return
        table = pa.concat_tables([self._read(path) for path in single])
        digest = hashlib.sha256("".join(path.name for path in single).encode()).hexdigest()
        self._write(table, f"{_MANY}{digest[:32]}.parquet")
        for path in single:
            path.unlink()

    def known_contents(self, table: pa.Table) -> dict[FileState, str]:
        """SHA-256 of files by their state, of all recordings in `table`."""
        columns = (table[name].to_pylist() for name in ("path", "size", "changed", "content"))
        return {(path, size, changed): content for path, size, changed, content in zip(*columns, strict=True)}

    def _read(self, path: Path) -> pa.Table:
        try:
            return pq.read_table(path, schema=SCHEMA)
        except (OSError, pa.ArrowException) as error:
            raise BadInput(
                f"{path} is damaged ({' '.join(str(error).split())[:80]}); remove it, and run `ident fleet` again"
            ) from None

    def _write(self, table: pa.Table, name: str) -> None:
        try:
            with replacement(self._table / name) as partial:
                pq.write_table(table, partial, compression="zstd")
                _flush(partial)
        except OSError as error:
            reason = "the disk is full" if error.errno == errno.ENOSPC else error.strerror
            raise BadInput(
                f"store {self.folder} cannot be written: {reason}; what it holds is kept. Make room and run again"
            ) from None


def _flush(path: Path) -> None:
    """Wait until the file's content is on the disk, before it gets its name."""
    with path.open("rb") as stream:
        os.fsync(stream.fileno())
