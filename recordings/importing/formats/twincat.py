"""Text export of TwinCAT Scope View (Beckhoff): groups of columns, each a time and the channels that share it.

The line of names tells the columns: where it repeats its key, `Name`, stands a time, and behind it stand its
channels: one ("Timelines: All"), or all that follow each other with one sample time ("For each sampletime"). The
cells of groups that have ended are blank, or left out at the end of the row.

Times are in ms from the start of the export, or in ticks of 100 ns since 1601 ("Full Timestamp"). Channels of other
groups than the first are interpolated at its instants. The format is described at https://infosys.beckhoff.com
(TE13xx, TC3 Scope View, "Export to csv").
"""

import re
from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from itertools import pairwise
from pathlib import Path

import numpy as np

from recordings.errors import BadInput
from recordings.importing.layout import TextLayout, decode, lines_of, table_of_lines
from recordings.importing.table import Table, distinct
from recordings.interpolation import interpolate_within_gaps
from recordings.recording import Floats

_HEAD = re.compile(rb"^(?:\xef\xbb\xbf)?Name([\t;:|, ])[^\r\n]*\r?\nFile\1")
_KEY = re.compile(
    r"Name|Symbol(Name|Comment|Based)|Data-Type|SampleTime(\[ms\])?|VariableSize|Index(Group|Offset)|Net[Ii][Dd]|Port|"
    r"BitMask|(Unit )?(Offset|ScaleFactor)|Unit"
)
"""Begins a line of the header, where others continue a comment."""
_KIND = re.compile(r"\s*\([^()]*\)$")
"""What is measured in a unit, as in "Nm (Torque)"; "(None)" is no unit."""
_PLAIN = {"ScaleFactor": "1", "Offset": "0", "Unit ScaleFactor": "1", "Unit Offset": "0"}
_START = re.compile(r"^Start(?:time of export|Record)\W(\d{15,18})\b", re.MULTILINE)
_EPOCH = datetime(1601, 1, 1, tzinfo=UTC)
_TICKS_PER_MS = 1e4
_FULL_STAMP_DIGITS = 16
"""A time of so many digits is a full time stamp in ticks; in ms it would be 30,000 years."""
_REMEDY = "export again with Timelines 'For each sampletime' and a tab as separator"


def recognises(path: Path, head: bytes) -> bool:
    """See `ImportFormat`."""
    return bool(_HEAD.match(head))


def read(path: Path) -> Table:
    """See `ImportFormat`."""
    text = decode(path.read_bytes(), path)
    lines, delimiter = lines_of(text), text[len("Name")]
    while lines[-1].strip() in ("", "EOF"):
        lines.pop()
    keys = {line.partition(delimiter)[0].strip(): place for place, line in reversed([*enumerate(lines)][2:])}
    places = {key: place for key, place in keys.items() if _KEY.fullmatch(key)}
    titles = _cells(lines[places["Name"]], delimiter) if "Name" in places else []
    edges = [*(k for k, title in enumerate(titles) if title == "Name"), len(titles)]
    if len(edges) < 2 or any(end - begin < 2 for begin, end in pairwise(edges)):
        raise BadInput(f"{path}: a line 'Name' with channels behind every 'Name' expected, none found; {_REMEDY}")
    names = distinct(["time", *titles[1:]])
    stated = _stated(path, lines, delimiter, places, edges, names)
    first = next((k for k in range(max(places.values()) + 1, len(lines)) if lines[k].strip()), len(lines))
    numbers = _numbers(path, lines, first, delimiter, edges, names)
    columns = {"time": numbers[np.isfinite(numbers[:, 0]), 0]}
    for begin, end in pairwise(edges):
        known = numbers[np.isfinite(numbers[:, begin])]
        for k in range(begin + 1, end):
            columns[names[k]] = interpolate_within_gaps(columns["time"], known[:, begin], known[:, k])
    units = {name: _KIND.sub("", cell) for name, cell in stated.get("Unit", {}).items() if _KIND.sub("", cell)}
    scaled = {name for key in _PLAIN for name, cell in stated.get(key, {}).items() if cell != _PLAIN[key]}
    notes = tuple(f"{name}: scale and offset of the header are taken as applied" for name in names if name in scaled)
    start = _START.search(text)
    date = (_EPOCH + timedelta(microseconds=int(start[1]) / 10)).isoformat(timespec="milliseconds") if start else None
    return Table(path, columns, {"time": "ms", **units}, date, notes=notes)


def _cells(line: str, delimiter: str, ends: Sequence[int] = ()) -> list[str]:
    """Cells of a line, of which there may be as many as the `ends` say; a separator may end the line, too."""
    cells = [cell.strip() for cell in line.split(delimiter)]
    return cells if cells[-1] or len(cells) in ends else cells[:-1]


def _stated(
    path: Path, lines: Sequence[str], delimiter: str, places: dict[str, int], edges: list[int], names: Sequence[str]
) -> dict[str, dict[str, str]]:
    """What the lines of the header at these `places` state of each channel, by key.

    A line with a decimal comma or a comment may be divided otherwise than the names are; that of the units must not.
    """
    stated = {}
    for key, place in places.items():
        cells = _cells(lines[place], delimiter, edges[-1:])
        if [*(k for k, cell in enumerate(cells) if cell == key), len(cells)] == edges:
            stated[key] = {name: cell for name, cell in zip(names, cells, strict=True) if cell != key}
        elif key == "Unit":
            raise BadInput(
                f"{path}, line {place + 1}: {edges[-1]} cells, 'Unit' below each 'Name', expected, "
                f"{len(cells)} found; {_REMEDY}"
            )
    return stated


def _numbers(
    path: Path, lines: Sequence[str], first: int, delimiter: str, edges: list[int], names: Sequence[str]
) -> Floats:
    """Numbers (n, k) of the lines from the `first` on, NaN in cells of groups that have ended; times in ms.

    Each of the `edges` begins a group with its time, the last one ends the row.
    """
    rows: list[list[str]] = []
    ends = edges[-1:]
    for place, line in enumerate(lines[first:], start=first + 1):
        rows.append(_cells(line, delimiter, ends))
        if len(rows[-1]) not in ends:
            raise BadInput(f"{path}, line {place}: {ends[-1]} cells expected, {len(rows[-1])} found; {_REMEDY}")
        ends = [end for end in edges[1:] if end <= len(rows[-1])]  # a group that has ended does not go on
    if not rows:
        raise BadInput(f"{path}: rows of numbers behind the header expected, none found; export the data as well")
    start = int(rows[0][0]) if rows[0][0].isdecimal() and len(rows[0][0]) >= _FULL_STAMP_DIGITS else 0
    if start:  # subtracted from whole numbers, because a float has no room for ticks since 1601
        rows = [[f"{int(c) - start}" if k in edges and c.isdecimal() else c for k, c in enumerate(r)] for r in rows]
    decimal = "," if delimiter != "," and any("," in line for line in lines[first:]) else "."
    whole = ["\t".join(row + [""] * (edges[-1] - len(row))) for row in rows]
    table = table_of_lines(path, [*lines[:first], *whole], TextLayout("\t", tuple(names), first, marks=decimal))
    numbers = np.column_stack([table.column(name) for name in names])
    numbers[:, edges[:-1]] /= _TICKS_PER_MS if start else 1.0
    for begin, end in pairwise(edges):
        group = numbers[:, begin:end]
        repeated = (np.diff(group, axis=0) == 0).all(axis=1)  # until the next ("Fill with previous")
        group[1:][repeated] = np.nan
        before = np.fmax.accumulate(np.concatenate([[-np.inf], group[:-1, 0]]))
        wrong = np.isfinite(group[:, 1:]).any(axis=1) & ~(group[:, 0] > before)
        if wrong.any() or np.isnan(group[:, 0]).all():
            place = int(np.argmax(wrong))
            raise BadInput(
                f"{path}, line {first + place + 1}, column '{names[begin]}': a time after {before[place]:g} ms "
                f"expected, {group[place, 0]:g} found; {_REMEDY}"
            )
    return numbers
