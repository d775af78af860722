"""Every format returns what was written, gaps as gaps."""

import csv
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from ident.basics import plugins
from ident.export import tables
from recordings.recording import Floats

CHUNKS = [
    {"time": np.array([0.0, 0.1]), "torque_1": np.array([1 / 3, np.nan])},
    {"time": np.array([0.2]), "torque_1": np.array([2.0])},
]


def from_csv(path: Path) -> dict[str, Floats]:
    with path.open() as stream:
        rows = list(csv.DictReader(stream))
    return {name: np.array([float(row[name] or "nan") for row in rows]) for name in rows[0]}


def from_parquet(path: Path) -> dict[str, Floats]:
    from pyarrow import parquet

    table = parquet.read_table(path)
    return {name: table[name].to_numpy() for name in table.column_names}


def from_json(path: Path) -> dict[str, Floats]:
    return {name: np.array(values, float) for name, values in json.loads(path.read_text())["columns"].items()}


READERS: dict[str, Callable[[Path], dict[str, Floats]]] = {
    "csv": from_csv,
    "parquet": from_parquet,
    "json": from_json,
}


@pytest.mark.parametrize("name", plugins.names(tables.__name__))
def test_every_format_keeps_numbers_and_gaps(name: str, tmp_path: Path) -> None:
    path = tmp_path / f"a.{name}"
    assert tables.load(tables.format_of(path))(iter(CHUNKS), path) == 3
    columns = READERS[name](path)
    assert list(columns) == ["time", "torque_1"]
    np.testing.assert_array_equal(columns["torque_1"], [1 / 3, np.nan, 2.0])
