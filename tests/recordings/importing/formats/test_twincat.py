"""The text export of TwinCAT Scope View in all its layouts, as its documentation and real exports have them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from recordings.errors import BadInput
from recordings.importing import formats
from recordings.importing.table import Table
from recordings.reader import read
from recordings.recording import Floats
from tests.conftest import Runner

START = 132959733843760000
"""2022-05-02T13:56:24.376 in ticks of 100 ns since 1601."""
POSITION, VELOCITY, TORQUE = "° (Angle)", "°/s (Angular velocity)", "Nm (Torque)"
Channels = Mapping[str, str]
"""Units by name."""


@dataclass(frozen=True)
class Group:
    """Channels that share a time [ms]."""

    channels: Channels
    period: float = 4.0
    count: int = 40
    begin: float = 0.0

    @property
    def samples(self) -> Floats:
        """Time and values (n, 1 + k)."""
        time = self.begin + self.period * np.arange(self.count)
        return np.column_stack([time, *(100 * np.sin(0.01 * time + sum(map(ord, name))) for name in self.channels)])


def export(
    groups: Sequence[Group],
    delimiter: str = "\t",
    decimal: str = ".",
    keys: Sequence[str] = ("SymbolComment", "SampleTime[ms]", "Unit", "Unit ScaleFactor", "Unit Offset"),
    start: str = "Starttime of export",
    gap: str | None = " ",
    stamps: bool = False,
    end: str = "",
) -> str:
    """Text of an export; a `gap` of None leaves out the cells of groups that have ended."""

    def cells(key: str, group: Group) -> list[str]:
        fixed = {
            "SampleTime[ms]": f"{group.period:g}".replace(".", decimal),
            "Unit ScaleFactor": "1",
            "Unit Offset": "0",
        }
        of = {"Name": {name: name for name in group.channels}, "Unit": group.channels}
        return [key, *(of.get(key, {}).get(name, fixed.get(key, "")) for name in group.channels)]

    def sample(row: Sequence[float]) -> list[str]:
        texts = [f"{x:.12g}".replace(".", decimal) for x in row]
        return [f"{START + round(row[0] * 1e4)}", *texts[1:]] if stamps else texts

    def line(*lists: Sequence[str]) -> str:
        return delimiter.join(cell for cells in lists for cell in cells) + end

    head = [line(["Name", "scope"]), line(["File", "c/scope"]), line([start, f"{START}", "Montag 2. Mai"]), "", ""]
    header = [line(*(cells(key, group) for group in groups)) for key in ("Name", *keys)]
    rows = []
    for samples in zip_longest(*(map(sample, group.samples) for group in groups)):
        row = [x or [gap or ""] * (1 + len(g.channels)) for x, g in zip(samples, groups, strict=True)]
        there = max(k for k, x in enumerate(samples) if x) + 1
        rows.append(line(*(row if gap is not None else row[:there])))
    return "\n".join([*head, *header, "", *rows]) + "\n"


def table_of(folder: Path, text: str) -> Table:
    path = folder / "scope.csv"
    path.write_bytes(text.encode())
    return formats.read(path)


def alone(channels: Channels, **of: Any) -> list[Group]:
    """Return a group for each channel, as with Timelines "All"."""
    return [Group({name: unit}, **of) for name, unit in channels.items()]


AXIS = {"ActPos": POSITION, "ActVelo": VELOCITY, "ActTorque": TORQUE}
ONE = [Group(AXIS)]
ALL = alone(AXIS)
SLOW = [Group({"ActPos": POSITION}, 1.0), Group({"ActTorque": TORQUE, "Bit": "(None)"}, 5.0, 8)]
THREE = [Group({"q": ""}, 0.2, 200), Group({"a": "", "b": ""}, 1.0, 40), Group({"slow": ""}, 5.0, 8, begin=-3.0)]

ACCEPTED: dict[str, tuple[list[Group], dict[str, Any]]] = {
    "a time for each sample time": (ONE, {}),
    "a time for each channel": (ALL, {}),
    "semicolon and decimal comma": (ONE, {"delimiter": ";", "decimal": ","}),
    "semicolon and decimal point, for each channel": (ALL, {"delimiter": ";"}),
    "tab and decimal comma": (SLOW, {"decimal": ","}),
    "comma": (ONE, {"delimiter": ","}),
    "comma, names alone": (SLOW, {"delimiter": ",", "keys": ()}),
    "comma, where the header has decimal commas": (THREE, {"delimiter": ",", "end": ","}),
    "colon": (ALL, {"delimiter": ":"}),
    "blank, names alone": (ONE, {"delimiter": " ", "keys": ()}),
    "names alone": (THREE, {"keys": ()}),
    "the faster group first, empty cells": (SLOW, {"gap": ""}),
    "the slower group first": (SLOW[::-1], {}),
    "sorted: rows end with the groups": (SLOW, {"gap": None}),
    "the longer group behind the shorter": ([Group({"a": ""}, count=20), Group({"b": ""}, 2.0, 40)], {}),
    "a group that begins later": (THREE, {"decimal": ",", "gap": ""}),
    "full time stamps": (ALL, {"stamps": True}),
    "full time stamps for each sample time": (THREE, {"stamps": True, "delimiter": ";", "decimal": ","}),
    "a separator ends the lines": (ALL, {"end": "\t"}),
    "a separator ends the lines, groups end before": (SLOW, {"end": ";", "delimiter": ";", "gap": None}),
    "TwinCAT 2": (ALL, {"start": "StartRecord", "decimal": ","}),
}


def expected(groups: Sequence[Group], name: str) -> Floats:
    """Truth at the times of the first group; NaN more than a period away from that of the channel."""
    instants = groups[0].samples[:, 0]
    group = next(group for group in groups if name in group.channels)
    time, values = group.samples[:, 0], group.samples[:, 1 + list(group.channels).index(name)]
    near = (instants >= time[0] - group.period) & (instants <= time[-1] + group.period)
    return np.where(near, np.interp(instants, time, values), np.nan)


@pytest.mark.parametrize("name", ACCEPTED)
def test_every_layout_has_the_same_values(name: str, tmp_path: Path) -> None:
    groups, how = ACCEPTED[name]
    table = table_of(tmp_path, export(groups, **how))
    channels = {channel: unit for group in groups for channel, unit in group.channels.items()}
    assert list(table.columns) == ["time", *channels]
    first = groups[0].samples[:, 0]
    np.testing.assert_allclose(table.columns["time"], first, atol=1e-9)
    for channel in channels:
        np.testing.assert_allclose(table.columns[channel], expected(groups, channel), atol=1e-6, err_msg=channel)
    stated = {channel: unit.split(" ")[0] for channel, unit in channels.items() if unit not in ("", "(None)")}
    assert table.units == {"time": "ms", **(stated if "Unit" in how.get("keys", ["Unit"]) else {})}
    assert (table.start, table.notes) == ("2022-05-02T13:56:24.376+00:00", ())


def replaced(text: str, *pairs: tuple[str, str]) -> str:
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    return text


PLAIN = export(ONE)
ROWS = PLAIN.split("\n\n")[-1]
COMMENT = ("SymbolComment\t\t\t\n", "SymbolComment\tfirst line\n1\t2\n\n(* end *)\t\t\n")
SAME = {
    "EOF": PLAIN + "EOF\n\n",
    "Windows": "\N{BYTE ORDER MARK}" + PLAIN.replace("\n", "\r\n"),
    "a comment of several lines": replaced(PLAIN, COMMENT),
    "rows just below the header": replaced(PLAIN, (f"\n\n{ROWS}", f"\n{ROWS}")),
    "two empty lines above the rows": replaced(PLAIN, (ROWS, f"\n{ROWS}")),
    "a sample that is repeated": replaced(PLAIN, (ROWS, "".join(2 * line for line in ROWS.splitlines(True)))),
    "a date in words": replaced(PLAIN, (f"\t{START}\t", f"\t{START}\tx\ty\t")),
}


@pytest.mark.parametrize("name", SAME)
def test_other_texts_of_the_same_values(name: str, tmp_path: Path) -> None:
    plain, other = table_of(tmp_path, PLAIN), table_of(tmp_path, SAME[name])
    assert (plain.units, plain.start) == (other.units, other.start)
    for column, values in plain.columns.items():
        np.testing.assert_array_equal(other.columns[column], values)


def test_names_that_stand_twice_have_their_place(tmp_path: Path) -> None:
    text = replaced(export(ALL), ("ActTorque", "ActPos"), ("ActVelo", "time"))
    assert list(table_of(tmp_path, text).columns) == ["time", "ActPos", "time#4", "ActPos#6"]


def test_what_the_header_leaves_open_is_said(tmp_path: Path) -> None:
    scaled = replaced(PLAIN, ("Unit Offset\t0\t0", "Unit Offset\t0\t10"), (TORQUE, "oz in (Torque)"))
    table = table_of(tmp_path, scaled)
    assert table.notes == ("ActVelo: scale and offset of the header are taken as applied",)
    assert table.units["ActTorque"] == "oz in"


def test_a_gap_stays_one(tmp_path: Path) -> None:
    lines = export(ONE).splitlines()
    lines[-10] = lines[-10].rpartition("\t")[0] + "\t "
    table = table_of(tmp_path, "\n".join(lines))
    assert np.flatnonzero(np.isnan(table.columns["ActTorque"])).tolist() == [30]
    assert not np.isnan(table.columns["ActPos"]).any()


def changed(text: str, place: int, line: str | None) -> str:
    """The text with another line at `place`, counted from the end; None: without it."""
    lines = text.splitlines()
    lines[place : place + 1 or None] = [] if line is None else [line]
    return "\n".join(lines)


def without_times(text: str) -> str:
    """Return the text without its columns of time, as with Timelines "None"."""
    head, rows = text.rsplit("\n\n", 1)
    return head + "\n\n" + "\n".join("\t".join(row.split("\t")[1::2]) for row in rows.splitlines())


PAIR = alone({"a": "", "b": ""})
REFUSED = {
    "no channels": (PLAIN.split("Name\tActPos")[0], "a line 'Name' with channels behind every 'Name' expected"),
    "a time without channels": (PLAIN.replace("ActTorque", "Name"), "channels behind every 'Name' expected"),
    "no rows": (PLAIN.replace(ROWS, ""), "rows of numbers behind the header expected"),
    "no times": (without_times(export(ALL)), "line 13: 6 cells expected, 3 found"),
    "no times, two channels": (without_times(export(PAIR)), "line 13: 4 cells expected, 2 found"),
    "a cell too many": (changed(PLAIN, -1, "156\t1\t2\t3\t4"), "line 52: 4 cells expected, 5 found"),
    "a cut row": (changed(PLAIN, -1, "156\t1"), "line 52: 4 cells expected, 2 found"),
    "a row in the middle that ends with a group": (
        changed(export(PAIR), -2, "152\t1"),
        "line 52: 2 cells expected, 4 found; export again with Timelines 'For each sampletime' and a tab",
    ),
    "an empty row": (changed(PLAIN, -2, ""), "line 51: 4 cells expected, 0 found"),
    "comma and decimal comma": (export(ONE, ",", ","), "line 13: 4 cells expected, 7 found"),
    "a text": (changed(PLAIN, -1, "156\t1\tx\t3"), "line 52, column 'ActVelo': a number expected, 'x' found"),
    "a text at first": (PLAIN.replace("\n0\t", "\nx\t"), "line 13, column 'time': a number expected, 'x' found"),
    "points and commas": (changed(PLAIN, -1, "156\t1.234,5\t2\t3"), "line 13, column 'ActPos': a number expected"),
    "a time that falls": (
        changed(PLAIN, -1, "151\t1\t2\t3"),
        "line 52, column 'time': a time after 152 ms expected, 151",
    ),
    "a time twice, with other values": (
        changed(PLAIN, -1, "152\t1\t2\t3"),
        "line 52, column 'time': a time after 152",
    ),
    "a value without a time": (changed(PLAIN, -1, " \t1\t2\t3"), "line 52, column 'time': a time after 152 ms"),
    "a channel that is called Name": (export([Group({"a": "", "Name": "", "b": ""})], keys=()), "a time after"),
    "units that are divided otherwise": (
        PLAIN.replace("° (A", "°\t(A"),
        "line 9: 4 cells, 'Unit' below each 'Name',",
    ),
    "a channel called Name beside units": (
        export([Group({"a": "", "Name": "", "b": ""})]),
        "line 9: 4 cells, 'Unit' below each 'Name', expected, 4 found",
    ),
    "marks behind the rows": (PLAIN + "Marker\t1\n", "line 53: 4 cells expected, 2 found"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_does_not_fit_is_refused(name: str, tmp_path: Path) -> None:
    text, reason = REFUSED[name]
    with pytest.raises(BadInput) as refused:
        table_of(tmp_path, text)
    assert reason in str(refused.value)


def test_an_export_for_each_sample_time_becomes_a_recording(tmp_path: Path, daq_in_process: Runner) -> None:
    (tmp_path / "one_axis.csv").write_text(export([Group(AXIS, count=3000)]), encoding="utf-8")
    done = daq_in_process("import", "one_axis.csv", "--guess", "--yes", "--out", "run.mcap")
    assert done.code == 0, done.err
    recording, truth = read(tmp_path / "run.mcap"), Group(AXIS, count=3000).samples
    assert recording.effort is not None
    np.testing.assert_allclose(recording.time - recording.time[0], truth[:, 0] / 1e3, atol=1e-6)
    np.testing.assert_allclose(recording.position[:, 0], np.deg2rad(truth[:, 1]), atol=1e-6)
    np.testing.assert_allclose(recording.effort[:, 0], truth[:, 3], atol=1e-6)
