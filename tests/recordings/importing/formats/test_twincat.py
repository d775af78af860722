"""The CSV export of TwinCAT Scope View, as its documentation and real exports have it."""

from pathlib import Path

import numpy as np
import pytest

from recordings.errors import BadInput
from recordings.importing import formats
from recordings.importing.table import BagPart, Table

HEAD = [
    "Name|scope",
    "File|c:/scope.csv",
    "Starttime of export|132959733843760000|Montag, 2. Mai 2022|15:56:24.376",
    "Endtime of export|132959733853750000|Montag, 2. Mai 2022|15:56:25.375",
    "",
    "",
]


def exported(channels: dict[str, tuple[str, str]], rows: list[str]) -> list[str]:
    """Lines of a file with `channels`: sample time [ms] and unit by name."""
    header = {
        "Name": list(channels),
        "SymbolComment": ["" for _ in channels],
        "SampleTime[ms]": [period for period, _ in channels.values()],
        "BitMask": ["0xffffffffffffffff" for _ in channels],
        "Unit": [unit for _, unit in channels.values()],
    }
    return [*HEAD, *("|".join(f"{key}|{x}" for x in values) for key, values in header.items()), "", *rows]


def table_of(folder: Path, lines: list[str], delimiter: str = "\t") -> Table:
    path = folder / "scope.csv"
    path.write_text("\n".join(lines).replace("|", delimiter) + "\n", encoding="utf-8")
    return formats.read(path, BagPart())


CHANNELS = {"ActPos": ("1", "° (Angle)"), "Torque": ("1", "(None)")}


@pytest.mark.parametrize("delimiter", ["\t", ";"])
def test_every_channel_has_a_time_of_its_own(delimiter: str, tmp_path: Path) -> None:
    lines = exported(CHANNELS, ["0|1,5|0|-3", "1|2,5|1|-4", "2|3,5|2|-5", "EOF"])
    table = table_of(tmp_path, lines, delimiter)
    np.testing.assert_array_equal(table.columns["time"], [0, 1, 2])
    np.testing.assert_array_equal(table.columns["ActPos"], [1.5, 2.5, 3.5])
    np.testing.assert_array_equal(table.columns["Torque"], [-3, -4, -5])
    assert dict(table.units) == {"time": "ms", "ActPos": "°"}
    assert table.start == "2022-05-02T13:56:24.376+00:00"


def test_channels_share_the_time_of_their_sample_time(tmp_path: Path) -> None:
    channels = {"a": ("1", ""), "b": ("1", ""), "slow": ("2", "")}
    table = table_of(tmp_path, exported(channels, ["0|1|10|0|5", "1|2|20|2|7", "2|3|30||", "3|4|40||"]))
    np.testing.assert_array_equal(table.columns["b"], [10, 20, 30, 40])
    np.testing.assert_array_equal(table.columns["slow"], [5, 6, 7, 7])


def test_full_timestamps_are_ticks_of_100_ns(tmp_path: Path) -> None:
    ticks = 132959733843760000
    rows = [f"{ticks + 10_000 * k}|{k}|{ticks + 10_000 * k}|{k}" for k in range(3)]
    table = table_of(tmp_path, exported(CHANNELS, rows))
    np.testing.assert_allclose(table.columns["time"], [0, 1, 2], atol=0.01)


def test_channels_of_one_name_are_told_apart(tmp_path: Path) -> None:
    lines = exported(CHANNELS, ["0|1|0|-3", "1|2|1|-4"])
    table = table_of(tmp_path, [line.replace("Torque", "ActPos") for line in lines])
    assert list(table.columns) == ["time", "ActPos", "ActPos#2"]


@pytest.mark.parametrize(
    ("lines", "reason"),
    [
        (HEAD, "a line 'Name' with the channels expected"),
        (exported(CHANNELS, []), "rows of numbers behind the header expected"),
        (exported(CHANNELS, ["0|1|0|x"]), r"row 1 of the data .* a number expected, 'x' found"),
        (exported({**CHANNELS, "third": ("1", "")}, ["0|1|2", "1|2|2"]), "export with Timelines 'All'"),
    ],
)
def test_damaged_exports_are_refused(lines: list[str], reason: str, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=reason):
        table_of(tmp_path, lines)
