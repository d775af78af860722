"""Reading a recording piece by piece: a file, one that is still being written, or a stream."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np
from mcap.opcode import Opcode

from recordings.chunk import RECORD, RECORD_HEAD
from recordings.container import MAGIC, Batch, RecordLoader
from recordings.errors import ForeignFile
from recordings.recording import Recording, Run
from recordings.sync_grid import SYNC_TOPICS, SyncGrid, check_container, nanoseconds, rig_of, run_of, sync_stamps

PIECE = 0.25
"""Least duration of a piece [s]: tables of fewer samples would take more time than they hold."""
_HELD_BACK = 50_000_000
"""Messages of the same SYNC may stand in two chunks: the newest wait so long for the others [ns]."""
_POLL = 0.05
"""Pause before a file that is still being written is looked at again [s]."""
_BLOCK = 1 << 20
_TOPICS = (*SYNC_TOPICS, "/extra")


def pieces(file: BinaryIO, path: Path, *, growing: Callable[[], bool] = lambda: False) -> Iterator[Recording]:
    """Yield the samples of an MCAP `file` in pieces; `path`: its name. Their time counts from the first sample.

    growing: asked at the end of a file that is not complete, whether to wait for more.

    Raises:
        BadInput: it is not a recording of this program, is damaged, or holds no samples.
    """
    if _read(file, len(MAGIC), growing) != MAGIC:
        raise ForeignFile(f"{path} is not an MCAP file", path)
    loader = RecordLoader(path, _TOPICS)
    samples = _Samples(loader)
    while head := _read(file, RECORD_HEAD, growing):
        opcode, length = RECORD.unpack(head)
        body = _read(file, length, growing)
        if body is None or opcode in (Opcode.DATA_END, Opcode.FOOTER):
            break
        loader.take(opcode, body)
        if opcode == Opcode.CHUNK and (piece := samples.taken(PIECE)) is not None:
            yield piece
    last = samples.taken(0.0, everything=True)
    if last is not None:
        yield last


def _read(file: BinaryIO, count: int, growing: Callable[[], bool]) -> bytes | None:
    """Read the next `count` bytes; None where the file ends before and does not grow."""
    parts = bytearray()
    while len(parts) < count:
        part = file.read(min(count - len(parts), _BLOCK))
        if part:
            parts += part
        elif growing():
            time.sleep(_POLL)
        else:
            return None
    return bytes(parts)


class _Samples:
    """The messages of a loader that are not in a piece yet."""

    def __init__(self, loader: RecordLoader) -> None:
        self._container = loader.container
        self._run: Run | None = None
        self._start: int | None = None

    def taken(self, least: float, everything: bool = False) -> Recording | None:
        """The next piece, of at `least` [s]; None: there is not enough yet. `everything`: nothing comes any more."""
        if self._run is None:
            self._container = check_container(self._container, SYNC_TOPICS)
            self._run, self._rig = run_of(self._container), rig_of(self._container)
            if everything:
                sync_stamps(self._container, self._run)
        batches = self._container.batches
        if not any(batches.get(topic) for topic in SYNC_TOPICS):
            return None
        stamps = sync_stamps(self._container, self._run)
        end = int(stamps[-1]) + 1 if everything else int(stamps[-1]) - _HELD_BACK
        if end - stamps[0] <= least * 1e9:
            return None
        self._start = int(stamps[0]) if self._start is None else self._start
        self._container.batches = _part(batches, -1, end)
        grid = SyncGrid(self._container, self._rig, stamps[stamps < end])
        result = grid.recording(self._run, self._start)
        self._container.batches = _part(batches, end, np.inf)
        return result


def _part(batches: dict[str, list[Batch]], first: float, end: float) -> dict[str, list[Batch]]:
    """Messages with a stamp from `first` to before `end` [ns]."""
    result: dict[str, list[Batch]] = {}
    for topic, of_topic in batches.items():
        for batch in of_topic:
            stamps = nanoseconds(batch["message"])
            inside = (stamps >= first) & (stamps < end)
            if inside.any():
                result.setdefault(topic, []).append(batch[inside])
    return result
