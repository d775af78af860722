"""Text tables of many makes give the same numbers."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from recordings.errors import BadInput
from recordings.importing import formats
from recordings.importing.table import Table

NUMBERS = np.array([[0.0, -1.5, 2.25], [0.002, 1e-3, np.nan], [0.004, 12.0, -3.0]])


def table_of(folder: Path, content: str | bytes) -> Table:
    path = folder / "data.txt"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return formats.read(path)


MAKES: dict[str, str | bytes] = {
    "plain": "t,a,b\n0,-1.5,2.25\n0.002,0.001,\n0.004,12,-3\n",
    "semicolons, decimal commas": "t;a;b\n0;-1,5;2,25\n0,002;1e-3;\n0,004;12,0;-3\n",
    "tabs": "t\ta\tb\n0\t-1.5\t2.25\n0.002\t0.001\tNaN\n0.004\t12\t-3\n",
    "tabs, decimal commas": "t\ta\tb\n0\t-1,5\t2,25\n0,002\t0,001\t\n0,004\t12\t-3\n",
    "blanks": "  t   a   b\n 0  -1.5  2.25\n 0.002 1.0E-03  nan\n 0.004 12 -3\n",
    "bars": "t|a|b\n0|-1.5|2.25\n0.002|0.001|null\n0.004|12|-3\n",
    "quotes": '"t","a","b"\n"0","-1.5","2.25"\n"0.002","0.001",""\n"0.004","12","-3"\n',
    "quoted decimal commas": '"t","a","b"\n"0,0","-1,5","2,25"\n"0,002","0,001",""\n"0,004","12,0","-3"\n',
    "comments": "# made by a logger\n% rate 500\nt,a,b\n0,-1.5,2.25\n# pause\n0.002,0.001,\n0.004,12,-3\n",
    "header in a comment": "# t,a,b\n0,-1.5,2.25\n0.002,0.001,nan\n0.004,12,-3\n",
    "preamble": "Drive;X5\nSample rate;500\n\nt;a;b\n0;-1.5;2.25\n0.002;0.001;\n0.004;12;-3\n",
    "delimiter at the end": "t;a;b;\n0;-1.5;2.25;\n0.002;0.001;;\n0.004;12;-3;\n",
    "delimiter at the end of rows": "t;a;b\n0;-1.5;2.25;\n0.002;0.001;;\n0.004;12;-3;\n",
    "blanks around": "t , a , b\r\n0 , -1.5 , 2.25\r\n0.002 , 0.001 , \r\n0.004 , 12 , -3\r\n",
    "UTF-16": "t,a,b\n0,-1.5,2.25\n0.002,0.001,\n0.004,12,-3\n".encode("utf-16"),
    "byte order mark": "\ufefft,a,b\n0,-1.5,2.25\n0.002,0.001,\n0.004,12,-3\n",
    "end mark": "t,a,b\n0,-1.5,2.25\n0.002,0.001,\n0.004,12,-3\nEOF\n\n",
    "Fortran exponents": "t a b\n0 -1.5D0 2.25\n0.002 1.0D-03 nan\n0.004 1.2D+01 -3\n",
}


@pytest.mark.parametrize("make", MAKES)
def test_makes_of_csv_give_the_same_numbers(make: str, tmp_path: Path) -> None:
    table = table_of(tmp_path, MAKES[make])
    assert list(table.columns)[:3] == ["t", "a", "b"]
    for name, column in zip("tab", NUMBERS.T, strict=True):
        np.testing.assert_array_equal(table.columns[name], column)


def test_units_stand_in_brackets_or_in_a_line_of_their_own(tmp_path: Path) -> None:
    inside = table_of(tmp_path, "Zeit [ms];Winkel (°);axis[1];Moment [%]\n0;1;2;3\n1;2;3;4\n".encode("cp1252"))
    assert dict(inside.units) == {"Zeit": "ms", "Winkel": "°", "Moment": "%"}
    assert list(inside.columns) == ["Zeit", "Winkel", "axis[1]", "Moment"]
    below = table_of(tmp_path, "t,q,x,i\ns,rad,,mA\n0,1,2,3\n1,2,3,4\n")
    assert dict(below.units) == {"t": "s", "q": "rad", "i": "mA"}
    np.testing.assert_array_equal(below.columns["q"], [1, 2])


@pytest.mark.parametrize(
    ("cells", "start"),
    [
        (("2026-01-05T08:00:00Z", "2026-01-05T08:00:00.250Z"), "2026-01-05T08:00:00.000+00:00"),
        (("2026-01-05 09:00:00,0+01:00", "2026-01-05 09:00:00,25+01:00"), "2026-01-05T09:00:00.000+01:00"),
        (("05.01.2026 08:00:00.000", "05.01.2026 08:00:00.250"), "2026-01-05T08:00:00.000+00:00"),
        (("2026/01/05 08:00:00.000", "2026/01/05 08:00:00.250"), "2026-01-05T08:00:00.000+00:00"),
        (("23:59:59.900", "0:00:00.150"), None),
    ],
)
def test_dates_become_seconds(cells: tuple[str, str], start: str | None, tmp_path: Path) -> None:
    table = table_of(tmp_path, f"t;a;b\n{cells[0]};1;2\n{cells[1]};2;3\n")
    np.testing.assert_allclose(table.columns["t"], [0, 0.25], atol=1e-9)
    assert table.start == start


def test_text_makes_a_column_unusable_only_if_it_is_used(tmp_path: Path) -> None:
    table = table_of(tmp_path, "t,a,state\n0,1,OK\n1,2,OK\n2,x,3\n")
    np.testing.assert_array_equal(table.column("t"), [0, 1, 2])
    for name, place in (
        ("a", "line 4, column 'a': a number expected, 'x' found"),
        ("state", "line 2, column 'state'"),
    ):
        with pytest.raises(BadInput, match=place):
            table.column(name)


def test_columns_without_names_get_numbers(tmp_path: Path) -> None:
    table = table_of(tmp_path, "0,1,2\n1,2,3\n2,3,4\n")
    assert list(table.columns) == ["#1", "#2", "#3"]
    np.testing.assert_array_equal(table.column("row"), [0, 1, 2])


@pytest.mark.parametrize("gaps", ["0.0;nan;nan", "0.0;;", "nan;nan;0.5"])
def test_rows_of_gaps_may_come_first(tmp_path: Path, gaps: str) -> None:
    table = table_of(tmp_path, f"time;q;tau\n{gaps}\n{gaps}\n0.1;1.5;2.5\n0.2;1.5;2.5\n")
    assert len(table.column("q")) == 4


@given(
    values=st.lists(st.tuples(*[st.floats(allow_nan=True, allow_infinity=False)] * 3), min_size=2, max_size=30),
    delimiter=st.sampled_from([";", "\t", "|", " "]),
    decimal=st.sampled_from([".", ","]),
)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_written_numbers_are_read_exactly(
    tmp_path: Path, values: list[tuple[float, ...]], delimiter: str, decimal: str
) -> None:
    rows = [delimiter.join(repr(x).replace(".", decimal) for x in row) for row in values]
    table = table_of(tmp_path, "\n".join([delimiter.join(("time", "q", "tau")), *rows]))
    np.testing.assert_array_equal(np.column_stack(list(table.columns.values())), np.array(values))
