"""Mappings: `--map` and TOML files."""

from pathlib import Path

import numpy as np
import pytest

from recordings.errors import BadInput
from recordings.importing.mapping import sources
from recordings.importing.table import Table

COLUMNS = {name: np.zeros(2) for name in ("time", "q1", "GVL.a:b", "position_1", "i [1]")}
TABLE = Table(Path("data.csv"), COLUMNS, {"q1": "deg"})


@pytest.mark.parametrize(
    ("entry", "target", "column", "unit"),
    [
        ("position_2=q1", "position_2", "q1", "deg"),
        ("position_2 = q1 : rad ", "position_2", "q1", "rad"),
        ("position_2=q1:*-1", "position_2", "q1", "*-1"),
        ("position_2=q1 [deg]", "position_2", "q1", "deg"),
        ("position_2=q1 [deg]:rad", "position_2", "q1", "rad"),
        ("effort_1=GVL.a:b", "effort_1", "GVL.a:b", ""),
        ("effort_1=GVL.a:b:A*0.12", "effort_1", "GVL.a:b", "A*0.12"),
        ("current_1=i [1]:mA", "current_1", "i [1]", "mA"),
        ("time=row:s*0.001", "time", "row", "s*0.001"),
    ],
)
def test_entry_names_column_and_unit(entry: str, target: str, column: str, unit: str) -> None:
    source = sources(TABLE, [entry])[target]
    assert (source.column, source.unit.text) == (column, unit)


def test_factor_alone_scales_the_unit_of_the_file() -> None:
    unit = sources(TABLE, ["position_2=q1:*-2"])["position_2"].unit
    assert (unit.dimension, unit.factor) == ("angle", pytest.approx(-2 * np.pi / 180))


def test_column_that_is_mapped_is_no_longer_what_it_is_called() -> None:
    columns = {"time": np.zeros(2), "effort_1": np.zeros(2)}  # of a ROS driver that publishes current there
    named = sources(Table(Path("bag"), columns), ["current_1=effort_1:mA"])
    assert {name: source.column for name, source in named.items()} == {"time": "time", "current_1": "effort_1"}


def test_toml_file_holds_the_same(tmp_path: Path) -> None:
    (tmp_path / "m.toml").write_text('position_2 = "q1:deg"\n"effort_1" = "GVL.a:b:A*0.12"\n')
    columns = sources(TABLE, [str(tmp_path / "m.toml"), "time=row"])
    assert {name: source.unit.text for name, source in columns.items()} == {
        "time": "",
        "position_1": "",
        "position_2": "deg",
        "effort_1": "A*0.12",
    }


@pytest.mark.parametrize("name", ["time", "position_1"])
def test_two_columns_of_the_name_of_a_quantity_are_refused(name: str) -> None:
    columns = {**COLUMNS, f"{name}#7": np.zeros(2)}
    with pytest.raises(BadInput, match=f'\'{name}\' twice found; .* map={{"{name}": "{name}#7"}}'):
        sources(Table(Path("data.csv"), columns), [])
    assert sources(Table(Path("data.csv"), columns), [f"{name}={name}#7"])[name].column == f"{name}#7"
