"""Export to the log format of can-utils (`candump -L`), such as `(1436509052.249713) can0 044#2A366C2BBA`."""

from pathlib import Path
from typing import BinaryIO

from recordings.errors import BadInput
from recordings.reader import read_can
from recordings.recording import CanFrames

CHANNEL = "can0"
"""Name of the interface in the log; recordings do not store the original name."""
_ERROR_FLAG = 0x2000_0000
_FRAMES = 50_000
"""Number of frames that are formatted at a time."""


def write(file: Path, stream: BinaryIO) -> str:
    """See `ExportFormat`."""
    frames = read_can(file)
    count = len(frames.id)
    if not count:
        raise BadInput(f"recording {file}: frames of a CAN bus expected, none found; export csv, parquet or mat")
    for first in range(0, count, _FRAMES):
        stream.write("".join(_lines(frames, slice(first, first + _FRAMES))).encode())
    return f"{count} frames"


def _lines(frames: CanFrames, rows: slice) -> list[str]:
    seconds, nanoseconds = (frames.log[rows] // 10**9).tolist(), (frames.log[rows] % 10**9).tolist()
    names = [
        f"{number | _ERROR_FLAG:08X}" if error else f"{number:08X}" if extended else f"{number:03X}"
        for number, extended, error in zip(
            frames.id[rows].tolist(), frames.extended[rows].tolist(), frames.error[rows].tolist(), strict=True
        )
    ]
    contents = [
        (f"R{dlc}" if dlc else "R") if rtr else data[:dlc].hex().upper()
        for dlc, rtr, data in zip(
            frames.dlc[rows].tolist(), frames.rtr[rows].tolist(), map(bytes, frames.data[rows]), strict=True
        )
    ]
    return [
        f"({second}.{nanosecond // 1000:06d}) {CHANNEL} {name}#{content}\n"
        for second, nanosecond, name, content in zip(seconds, nanoseconds, names, contents, strict=True)
    ]
