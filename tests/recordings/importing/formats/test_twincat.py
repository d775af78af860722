"""The CSV export of TwinCAT Scope View, as its documentation and real exports have it."""

from pathlib import Path

import numpy as np
import pytest

from recordings.errors import BadInput
from recordings.importing import formats
from recordings.importing.table import Table

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
    return formats.read(path)


CHANNELS = {"ActPos": ("1", "° (Angle)"), "Torque": ("1", "(None)")}
SLOW = {"a": ("1", ""), "b": ("1", ""), "slow": ("2", "")}
SAME = [line.replace("Torque", "ActPos") for line in exported(CHANNELS, ["0|1|0|-3", "1|2|1|-4"])]
TICKS = [132959733843760000 + 10_000 * k for k in range(3)]
EXPORTS: dict[str, tuple[list[str], dict[str, list[float]]]] = {
    "every channel with a time of its own": (
        exported(CHANNELS, ["0|1,5|0|-3", "1|2,5|1|-4", "2|3,5|2|-5", "EOF"]),
        {"time": [0, 1, 2], "ActPos": [1.5, 2.5, 3.5], "Torque": [-3, -4, -5]},
    ),
    "channels that share the time of their sample time": (
        exported(SLOW, ["0|1|10|0|5", "1|2|20|2|7", "2|3|30||", "3|4|40||"]),
        {"b": [10, 20, 30, 40], "slow": [5, 6, 7, 7]},
    ),
    "full timestamps in ticks of 100 ns": (
        exported(CHANNELS, [f"{tick}|{k}|{tick}|{k}" for k, tick in enumerate(TICKS)]),
        {"time": [0, 1, 2]},
    ),
    "channels of one name": (SAME, {"time": [0, 1], "ActPos": [1, 2], "ActPos#2": [-3, -4]}),
}


@pytest.mark.parametrize("delimiter", ["\t", ";"])
@pytest.mark.parametrize("name", EXPORTS)
def test_exports_become_columns(name: str, delimiter: str, tmp_path: Path) -> None:
    lines, columns = EXPORTS[name]
    table = table_of(tmp_path, lines, delimiter)
    for column, values in columns.items():
        np.testing.assert_allclose(table.columns[column], values, atol=0.01)
    assert (table.units["time"], table.start) == ("ms", "2022-05-02T13:56:24.376+00:00")
    assert set(table.units.values()) <= {"ms", "°"}


@pytest.mark.parametrize(
    ("lines", "reason"),
    [
        (HEAD, "a line 'Name' with the channels expected"),
        (exported(CHANNELS, []), "rows of numbers behind the header expected"),
        (exported(CHANNELS, ["0|1|0|x"]), "column '#4': a number expected, 'x' found"),
        (exported({**CHANNELS, "third": ("1", "")}, ["0|1|2", "1|2|2"]), "export with Timelines 'All'"),
    ],
)
def test_damaged_exports_are_refused(lines: list[str], reason: str, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=reason):
        table_of(tmp_path, lines)
