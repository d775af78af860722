"""Binary tables: vectors, matrices, structures, dates; logs of measurement systems: names, units, rasters, start."""

import os
import re
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pyarrow
import pytest
from pyarrow import feather, parquet
from scipy.io import savemat

from recordings.errors import BadInput
from recordings.importing.formats import read

TIME = np.arange(5) * 0.1
MATRIX = np.arange(10.0).reshape(5, 2)
LOGGED = np.arange(50) * 0.01
ANGLE = 30 * np.sin(LOGGED)


def library(name: str) -> Any:
    """The library that writes such files; its absence is a failure where everything has to be there."""
    return __import__(name) if os.environ.get("CI") else pytest.importorskip(name)


def write_mat73(path: Path, arrays: dict[str, np.ndarray]) -> None:
    """As MATLAB does: HDF5 behind a block of 512 bytes, matrices transposed."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, array in arrays.items():
            file[name] = np.atleast_2d(array.T)
            file[name].attrs["MATLAB_class"] = np.bytes_("double")
        file["title"] = np.array([[97], [98]], dtype=np.uint16)
        file["title"].attrs["MATLAB_class"] = np.bytes_("char")
    with path.open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


def write_hdf5(path: Path, arrays: dict[str, np.ndarray]) -> None:
    with h5py.File(path, "w") as file:
        file.update(arrays)
        file["position"].attrs["unit"] = "deg"


def write_mdf(path: Path) -> None:
    asammdf = library("asammdf")
    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal(k * ANGLE, LOGGED, name="q", unit="deg") for k in (1, 2)])
        file.append([asammdf.Signal(LOGGED[::10], LOGGED[::10], name="warm", unit="degC")])
        file.start_time = np.datetime64("2026-01-05T08:00:00").item()
        file.save(path)


def write_tdms(path: Path) -> None:
    nptdms = library("nptdms")
    waveform = {"wf_increment": 0.01, "wf_start_time": np.datetime64("2026-01-05T08:00:00"), "wf_start_offset": 0.0}
    channels = [
        nptdms.ChannelObject("log", name, values, {**waveform, "unit_string": "deg"})
        for name, values in {"q": ANGLE, "q#2": 2 * ANGLE}.items()
    ]
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment([*channels, nptdms.ChannelObject("log", "warm", LOGGED, waveform)])


ARRAYS: dict[str, Callable[[Path, dict[str, np.ndarray]], None]] = {
    "a.npz": lambda path, arrays: np.savez(path, **arrays),
    "packed.npz": lambda path, arrays: np.savez_compressed(path, **arrays),
    "a.mat": lambda path, arrays: savemat(path, arrays),
    "packed.mat": lambda path, arrays: savemat(path, arrays, do_compression=True, oned_as="column"),
    "v73.mat": write_mat73,
    "a.h5": write_hdf5,
}
ARROW: dict[str, Callable[[pyarrow.Table, Path], None]] = {
    "a.parquet": parquet.write_table,
    "a.feather": feather.write_feather,
}
LOGS = {"a.mf4": write_mdf, "a.tdms": write_tdms}
SMALL: dict[str, Callable[[Path], None]] = {
    **{name: partial(write, arrays={"time": TIME, "position": TIME}) for name, write in ARRAYS.items()},
    **{name: partial(write, pyarrow.table({"time": TIME})) for name, write in ARROW.items()},
    **LOGS,
}


@pytest.mark.parametrize("name", ARRAYS)
@pytest.mark.parametrize("transposed", [False, True])
def test_matrices_become_a_column_per_joint(name: str, transposed: bool, tmp_path: Path) -> None:
    arrays = {"time": TIME, "position": MATRIX.T if transposed else MATRIX, "mode": TIME > 0.2, "Ts": np.array(0.1)}
    ARRAYS[name](tmp_path / name, arrays)
    table = read(tmp_path / name)
    assert set(table.columns) == {"time", "position_1", "position_2", "mode"}
    np.testing.assert_array_equal(table.column("time"), TIME)
    np.testing.assert_array_equal(table.column("position_2"), MATRIX[:, 1])
    np.testing.assert_array_equal(table.column("mode"), [0, 0, 0, 1, 1])
    assert "Ts" in table.notes[0]
    assert table.units == (dict.fromkeys(("position_1", "position_2"), "deg") if name == "a.h5" else {})


def test_structures_and_tables_within_a_file_are_searched(tmp_path: Path) -> None:
    savemat(tmp_path / "a.mat", {"log": {"t": TIME, "axis": {"q": MATRIX, "name": "left"}}})
    assert list(read(tmp_path / "a.mat").columns) == ["log.t", "log.axis.q_1", "log.axis.q_2"]
    with h5py.File(tmp_path / "a.hdf5", "w") as file:
        file["run/log"] = np.zeros(5, dtype=[("t", "f8"), ("q", "f4")])
        file["run/name"] = "arm"
    assert list(read(tmp_path / "a.hdf5").columns) == ["run.log.t", "run.log.q"]


def test_units_in_brackets_and_in_attributes_of_any_case_are_read(tmp_path: Path) -> None:
    parquet.write_table(pyarrow.table({"torque [mNm]": [1.0, 2.0, 3.0]}), tmp_path / "a.parquet")
    assert read(tmp_path / "a.parquet").units == {"torque [mNm]": "mNm"}
    with h5py.File(tmp_path / "a.hdf5", "w") as file:
        file["torque"] = np.zeros(5)
        file["torque"].attrs["Units"] = "in-lb"
    assert read(tmp_path / "a.hdf5").units == {"torque": "in-lb"}


@pytest.mark.parametrize("name", ARROW)
def test_columns_of_arrow_files(name: str, tmp_path: Path) -> None:
    columns = {
        "stamp": pyarrow.array([0, 250_000_000, None], pyarrow.timestamp("ns", "UTC")),
        "q": [1.0, None, 3.0],
        "count": [1, None, 3],
        "both": [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]],
        "state": ["on", "off", None],
    }
    ARROW[name](pyarrow.table(columns), tmp_path / name)
    table = read(tmp_path / name)
    gap = np.nan
    for column, values in {
        "stamp": [0, 0.25, gap],
        "q": [1, gap, 3],
        "count": [1, gap, 3],
        "both_2": [2, 4, 6],
    }.items():
        np.testing.assert_array_equal(table.column(column), values)
    assert table.start == "1970-01-01T00:00:00.000+00:00"
    with pytest.raises(BadInput, match="column 'state': numbers expected, text found"):
        table.column("state")


@pytest.mark.parametrize("name", LOGS)
def test_channels_are_columns_with_their_units_and_start(name: str, tmp_path: Path) -> None:
    LOGS[name](tmp_path / name)
    table = read(tmp_path / name)
    first, second = (column for column in table.columns if column.startswith("q"))
    np.testing.assert_allclose(table.column("time"), LOGGED, atol=1e-12)
    np.testing.assert_allclose(table.column(first), ANGLE)
    np.testing.assert_allclose(table.column(second), 2 * ANGLE)
    np.testing.assert_allclose(table.column("warm")[:40], LOGGED[:40], atol=1e-12)
    assert table.units[first] == table.units[second] == "deg"
    assert str(table.start).startswith("2026-01-05T08:00:00")


def test_channels_without_a_waveform_have_no_time(tmp_path: Path) -> None:
    nptdms = library("nptdms")
    with nptdms.TdmsWriter(tmp_path / "a.tdms") as writer:
        writer.write_segment([nptdms.ChannelObject(group, "q", ANGLE) for group in ("left", "right")])
    assert list(read(tmp_path / "a.tdms").columns) == ["left.q", "right.q"]


@pytest.mark.parametrize("name", SMALL)
def test_damaged_files_are_refused_or_read_in_part(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    SMALL[name](path)
    whole = path.read_bytes()
    for size in (8, 16, 70, 150, 600, len(whole) // 2, len(whole) - 5):
        path.write_bytes(whole[:size])
        try:
            count = read(path).count
        except BadInput:
            continue
        assert count <= len(LOGGED) if name in LOGS else count in (0, len(TIME))


@pytest.mark.parametrize(
    ("content", "module", "command"),
    [
        (b"\x89HDF\r\n\x1a\n", "h5py", "pip install 'delta-workbench[hdf5]'"),
        (b"ARROW1", "pyarrow.feather", "pip install 'delta-workbench[parquet]'"),
        (b"MDF     4.10", "asammdf", "pip install 'delta-workbench[mdf4]'"),
        (b"TDSm", "nptdms", "pip install 'delta-workbench[tdms]'"),
    ],
)
def test_missing_library_is_said_with_the_command_that_installs_it(
    content: bytes, module: str, command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a").write_bytes(content)
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(BadInput, match=re.escape(command)):
        read(tmp_path / "a")
