"""MDF and TDMS, the files of measurement systems: names, units, rasters, start, damage."""

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from recordings.errors import BadInput
from recordings.importing import formats
from recordings.importing.table import BagPart, Table

TIME = np.arange(50) * 0.01
ANGLE = 30 * np.sin(TIME)


def library(name: str) -> Any:
    """The library that writes such files; its absence is a failure where everything has to be there."""
    return __import__(name) if os.environ.get("CI") else pytest.importorskip(name)


def read(path: Path) -> Table:
    return formats.read(path, BagPart())


def write_mdf(path: Path) -> None:
    asammdf = library("asammdf")
    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal(k * ANGLE, TIME, name="q", unit="deg") for k in (1, 2)])
        file.append([asammdf.Signal(TIME[::10], TIME[::10], name="warm", unit="degC")])
        file.start_time = np.datetime64("2026-01-05T08:00:00").item()
        file.save(path)


def write_tdms(path: Path) -> None:
    nptdms = library("nptdms")
    waveform = {"wf_increment": 0.01, "wf_start_time": np.datetime64("2026-01-05T08:00:00"), "wf_start_offset": 0.0}
    names = {"q": ANGLE, "q#2": 2 * ANGLE}
    channels = [
        nptdms.ChannelObject("log", name, values, {**waveform, "unit_string": "deg"})
        for name, values in names.items()
    ]
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment([*channels, nptdms.ChannelObject("log", "warm", TIME, waveform)])


WRITERS = {"a.mf4": write_mdf, "a.tdms": write_tdms}


@pytest.mark.parametrize("name", WRITERS)
def test_channels_are_columns_with_their_units_and_start(name: str, tmp_path: Path) -> None:
    WRITERS[name](tmp_path / name)
    table = read(tmp_path / name)
    first, second = (column for column in table.columns if column.startswith("q"))
    np.testing.assert_allclose(table.column("time"), TIME, atol=1e-12)
    np.testing.assert_allclose(table.column(first), ANGLE)
    np.testing.assert_allclose(table.column(second), 2 * ANGLE)
    np.testing.assert_allclose(table.column("warm")[:40], TIME[:40], atol=1e-12)
    assert table.units[first] == table.units[second] == "deg"
    assert str(table.start).startswith("2026-01-05T08:00:00")


@pytest.mark.parametrize("name", WRITERS)
def test_damaged_files_are_refused_or_read_in_part(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    WRITERS[name](path)
    whole = path.read_bytes()
    for size in (16, 70, 200, len(whole) // 2, len(whole) - 5):
        path.write_bytes(whole[:size])
        try:
            table = read(path)
        except BadInput:
            continue
        assert table.count <= len(TIME)


def test_channels_without_a_waveform_have_no_time(tmp_path: Path) -> None:
    nptdms = library("nptdms")
    with nptdms.TdmsWriter(tmp_path / "a.tdms") as writer:
        groups = [nptdms.ChannelObject(group, "q", ANGLE) for group in ("left", "right")]
        writer.write_segment(groups)
    assert list(read(tmp_path / "a.tdms").columns) == ["left.q", "right.q"]
