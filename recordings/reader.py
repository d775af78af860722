"""Reading a recording, complete or interrupted, into arrays."""

from pathlib import Path
from typing import Any

import numpy as np

from recordings import schemas
from recordings.cdr import Layout
from recordings.container import DECODE_ERRORS, Batch, load, open_records
from recordings.recording import CanFrames, Recording
from recordings.rig import Rig
from recordings.sync_grid import SYNC_TOPICS, SyncGrid, check_container, nanoseconds, rig_of, run_of, sync_stamps

Source = Path | Recording
"""A recording, or its file."""
_FIELDS = {
    *("header.stamp", "position", "velocity", "effort", "voltage", "statusword", "error_code", "repeat", "lateness"),
    *("value", "level", "name", "msg"),
}
"""Message fields that `read` uses, besides the joint names."""
_ALLOCATION_BYTES = 1 << 26
"""Size of one memory allocation [bytes]; the system provides only the pages in use."""
_SMALL_BATCH = 16
"""Batches with fewer messages get an array of their own."""


def read(path: Path, most: int | None = None) -> Recording:
    """Read a recording; from an interrupted one, everything that is intact.

    The messages of one SYNC are joined by their stamp. Missing values are gaps: NaN; 0 in statusword and error code;
    -1 in repeat.

    Args:
        most: number of bytes of the file to read, for a preview of the beginning of a long recording.

    Raises:
        BadInput: the file is missing, not MCAP, damaged, not a recording of this program, or holds no samples.
    """
    container = load(path, (*SYNC_TOPICS, "/events", "/extra"), _FieldSelector(), most)
    check_container(container, (*SYNC_TOPICS, "/events"))
    run = run_of(container)
    grid = SyncGrid(container, rig_of(container), sync_stamps(container, run))
    return grid.recording(run, int(grid.stamps[0]))


def opened(source: Source) -> Recording:
    """The recording that `source` is, or that it names.

    Raises:
        BadInput: as `read`.
    """
    return source if isinstance(source, Recording) else read(source)


def path_of(source: Source) -> Path:
    """The file of a recording; of one in memory its name."""
    return source.path if isinstance(source, Recording) else source


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
    return rig_of(check_container(load(path, ()), ()))


def read_can(path: Path) -> CanFrames:
    """Read the CAN frames of a recording in the order in which they were logged.

    Raises:
        BadInput: the file is missing, not MCAP, damaged, or not a recording of this program.
    """
    container = check_container(load(path, ("/can",)), ("/can",))
    # "tx" and "rx" have three bytes with the NUL; the empty array gives the dtype where there are no frames.
    none = np.empty(0, Layout(schemas.FIELDS["/can"], lambda *_: 3).dtype)
    batches = container.batches.get("/can", [])
    log = np.concatenate([np.empty(0, np.int64), *(batch["log"].astype(np.int64) for batch in batches)])
    order = np.argsort(log, kind="stable")
    frames = np.concatenate([none, *(batch["message"] for batch in batches)])[order]
    return CanFrames(
        stamp=nanoseconds(frames),
        log=log[order],
        id=frames["id"].astype(np.int64),
        dlc=frames["dlc"].astype(np.int64),
        data=frames["data"],
        sent=frames["header.frame_id"] == b"tx",
        rtr=frames["is_rtr"],
        extended=frames["is_extended"],
        error=frames["is_error"],
    )


class _FieldSelector:
    """Copies only the message fields that `read` uses, because all messages of an hour would fill the memory.

    The copies share a few large allocations; many small ones, once freed, would not return to the system.
    """

    def __init__(self) -> None:
        self._pieces: dict[np.dtype[Any], Batch] = {}

    def __call__(self, batch: Batch) -> Batch:
        names = [name for name in batch["message"].dtype.names or () if name in _FIELDS or name.startswith("name.")]
        if not names:  # messages of another program; `check_container` reports them
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
