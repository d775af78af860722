"""CSV export of TwinCAT Scope View (Beckhoff): a header per channel, a column of time before each channel or group.

The time columns are in ms from the start of the export, or in ticks of 100 ns since 1601 ("full timestamp"). Channels
with another sample time than the first are interpolated at its instants. The format is described at
https://infosys.beckhoff.com (TE13xx, TC3 Scope View, "Export to csv").
"""

import re
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from recordings.errors import BadInput
from recordings.importing.layout import TextLayout, decode, lines_of, table_of_lines
from recordings.importing.numerals import number
from recordings.importing.table import Table, distinct
from recordings.importing.units import parse
from recordings.interpolation import interpolate
from recordings.recording import Floats

_HEAD = re.compile(rb"^(?:\xef\xbb\xbf)?Name([\t;:|])[^\r\n]*\r?\nFile\1")
_EPOCH = datetime(1601, 1, 1, tzinfo=UTC)
_TICKS_PER_MS = 1e4
_FIRST_FULL_STAMP = 1e15
"""A larger time is a full time stamp in ticks; in ms it would be 30,000 years."""


def recognises(path: Path, head: bytes) -> bool:
    """See `ImportFormat`."""
    return bool(_HEAD.match(head))


def read(path: Path) -> Table:
    """See `ImportFormat`."""
    content = path.read_bytes()
    match = _HEAD.match(content)
    delimiter = match[1].decode() if match else "\t"
    lines = lines_of(decode(content, path))
    header, first = _header(path, lines, delimiter)
    rows = [line for line in lines[first:] if line.strip() and line.strip() != "EOF"]
    if not rows:
        raise BadInput(f"{path}: rows of numbers behind the header expected, none found; export the data as well")
    channels = distinct(header["Name"])
    table = _numbers(path, lines[:first], rows, delimiter)
    times, values = _pairs(path, table, len(channels), header)
    instants = times[0][np.isfinite(times[0])]
    columns = {"time": instants}
    for name, time, value in zip(channels, times, values, strict=True):
        columns[name] = interpolate(instants, time, value)
    stated = {
        name: unit.split(" ")[0]
        for name, unit in zip(channels, header.get("Unit", []), strict=False)
        if parse(unit.split(" ")[0])
    }
    return Table(path, columns, {"time": "ms", **stated}, _start(lines, delimiter))


def _header(path: Path, lines: list[str], delimiter: str) -> tuple[dict[str, list[str]], int]:
    """Header of the channels: a value per channel by key, and the index of the first line with data."""
    begin = next((k for k, line in enumerate(lines[2:], start=2) if line.startswith(f"Name{delimiter}")), None)
    if begin is None:
        raise BadInput(f"{path}: a line 'Name' with the channels expected, none found; export with the full header")
    header: dict[str, list[str]] = {}
    for place, line in enumerate(lines[begin:], start=begin):
        cells = line.split(delimiter)
        if not cells[0] or number(cells[0].strip(), ",") is not None or number(cells[0].strip(), ".") is not None:
            return header, place + (not line.strip())
        header[cells[0].strip()] = [cell.strip() for cell in cells[1::2]]
    return header, len(lines)


def _numbers(path: Path, before: list[str], rows: list[str], delimiter: str) -> Floats:
    """Numbers (n, width) of the rows, `before` which other lines stand; shorter rows end with gaps."""
    width = max(row.count(delimiter) for row in rows) + 1
    names = tuple(f"#{k + 1}" for k in range(width))
    layout = TextLayout(delimiter, names, len(before))
    whole = [row + delimiter * (width - 1 - row.count(delimiter)) for row in rows]
    table = table_of_lines(path, [*before, *whole], layout)
    return np.column_stack([table.column(name) for name in names])


def _pairs(path: Path, table: Floats, count: int, header: dict[str, list[str]]) -> tuple[list[Floats], list[Floats]]:
    """Time [ms] and values of each channel: every channel has a time of its own, or shares it with those before."""
    if table.shape[1] == 2 * count:
        times, values = list(table[:, ::2].T), list(table[:, 1::2].T)
    else:
        periods = header.get("SampleTime[ms]", [])
        times, values, column = [], [], 0
        for k in range(count):
            if k == 0 or (k < len(periods) and periods[k] != periods[k - 1]):
                time, column = column, column + 1
            times.append(table[:, min(time, table.shape[1] - 1)])
            values.append(table[:, min(column, table.shape[1] - 1)])
            column += 1
        if column != table.shape[1]:
            raise BadInput(
                f"{path}: a column of time for every channel, or for every sample time, expected, {table.shape[1]} "
                f"columns for {count} channels found; export with Timelines 'All'"
            )
    first = np.nanmin(times[0])
    scale = _TICKS_PER_MS if first > _FIRST_FULL_STAMP else 1.0
    return [(time - first * (scale > 1)) / scale for time in times], values


def _start(lines: list[str], delimiter: str) -> str | None:
    """ISO 8601 time of the first sample."""
    for line in lines[:10]:
        cells = line.split(delimiter)
        if cells[0].strip() in ("Starttime of export", "StartRecord") and len(cells) > 1 and cells[1].isdigit():
            return (_EPOCH + timedelta(microseconds=int(cells[1]) / 10)).isoformat(timespec="milliseconds")
    return None
