"""Errors of Python functions name arguments of Python, those of commands their options."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ident
from daq.program import program as daq_program
from recordings.errors import BadInput
from recordings.recording import Recording
from tests.ident.building import bench, record
from tests.running import ran

TIME = np.arange(400) / 100
WAVE = np.sin(3 * TIME)
AXIS = {"time": TIME, "position_1": WAVE, "effort_1": np.cos(3 * TIME)}
OPTION = re.compile(r"(?<![\w-])--[a-z]")


def of_frame(columns: dict[str, Any], **arguments: Any) -> Callable[[], Recording]:
    """A call with a data frame of these `columns`; None leaves one of `AXIS` out."""
    import pandas

    known = {name: values for name, values in (AXIS | columns).items() if values is not None}
    return lambda: ident.Recording.from_frame(pandas.DataFrame(known), **{"rig": bench(), **arguments})


@pytest.mark.parametrize(
    ("columns", "arguments", "advice"),
    [
        ({"time": None, "t": TIME}, {}, 'as in map={"time": "COLUMN:ms"}'),
        ({"time": 1e12 * TIME}, {}, 'as in map={"time": "time:ns"}'),
        ({"time": TIME[::-1]}, {}, 'as in map={"time": "row:s*0.001"}'),
        ({"position_1": None, "q": WAVE}, {}, 'as in map={"position_1": "COLUMN:deg"}'),
        ({"effort_1": None}, {}, 'as in map={"current_1": "COLUMN:A"}'),
        ({"effort_2": WAVE}, {}, 'map it with map={"effort_2": "COLUMN"}'),
        ({"effort_1": 1e20 * WAVE}, {}, 'as in map={"effort_1": "effort_1:UNIT"}'),
        ({"effort_1": None, "current_1": WAVE}, {}, "give torque.per_ampere in the rig file"),
        ({}, {"map": {"postion_1": "q"}}, "map: time, cycle, or"),
        ({}, {"map": {"position_1": "position_1:furlong"}}, "map position_1: a unit such as deg"),
        ({}, {"map": {"position_1": "position_1:counts"}}, "or give a rig with [[drives]]"),
        ({}, {"map": {"effort_1": "effort_1:A"}}, "and give a rig with torque.per_ampere"),
        ({}, {"rig": None}, "say what it is with rig, or map three"),
        ({f"{name}_{k}": WAVE for name in ("position", "effort") for k in range(1, 6)}, {"rig": None}, "leave the"),
        ({f"{name}_2": WAVE for name in ("position", "effort")}, {}, "found; map them, or choose another rig file"),
    ],
)
def test_a_frame_that_cannot_be_read(columns: dict[str, Any], arguments: dict[str, Any], advice: str) -> None:
    with pytest.raises(BadInput) as refused:
        of_frame(columns, **arguments)()
    assert advice in str(refused.value)
    assert not OPTION.search(str(refused.value)), refused.value
    assert "--guess" not in str(refused.value)


def test_a_fit_and_an_export_that_cannot_be(tmp_path: Path) -> None:
    once = record(noise=0.05, cycles=1)
    model = ident.fit(record(noise=0.05), method="ls")
    (tmp_path / "log.csv").write_text("t;q1\n")
    calls: dict[str, Callable[[], object]] = {
        'choose intervals="stationary"': lambda: ident.fit(once, method="ls", intervals="cycles"),
        "without: an effect of the base model": lambda: ident.fit(once, without="stribeck"),
        'such as effects="stribeck"': lambda: ident.fit(once, method="pso_nonlinear"),
        "change settings": lambda: model.export("c", tmp_path / "c", settings={"prefx": "left"}),
        "give it as on": lambda: model.export("mcap", tmp_path / "a.mcap"),
        "ident.read(": lambda: ident.fit(tmp_path / "log.csv"),
    }
    for advice, call in calls.items():
        with pytest.raises(BadInput) as refused:
            call()
        assert advice in str(refused.value), refused.value
        assert not OPTION.search(str(refused.value)), refused.value


def test_data_in_memory_are_mended_where_they_come_from() -> None:
    made = record(noise=0.05)
    assert made.effort is not None
    turned = ident.Recording.from_arrays(made.time, made.position, effort=-made.effort, rig=made.rig)
    with pytest.raises(
        BadInput, match=r"torque-sign: .* Mend what the recording was made of, as daq import FILE --map .* mends"
    ):
        ident.fit(replace(turned), method="ls")


def test_a_command_names_its_options(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.csv").write_text("t,q\n" + "".join(f"{k},{k % 7}\n" for k in range(40)))
    with pytest.raises(BadInput, match=r'--map "time=COLUMN:ms", or see daq import a\.csv --guess'):
        ran(daq_program, "import", "a.csv", "--out", "a.mcap", "--mechanism", "axes")
