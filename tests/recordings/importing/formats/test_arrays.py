"""NPZ, MAT, HDF5, Parquet and Feather: vectors, matrices, structures, dates."""

import re
import sys
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pyarrow
import pytest
from pyarrow import feather, parquet
from scipy.io import savemat

from recordings.errors import BadInput
from recordings.importing import formats
from recordings.importing.table import BagPart, Table

TIME = np.arange(5) * 0.1
MATRIX = np.arange(10.0).reshape(5, 2)


def read(path: Path) -> Table:
    return formats.read(path, BagPart())


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


WRITERS: dict[str, Callable[[Path, dict[str, np.ndarray]], None]] = {
    "npz": lambda path, arrays: np.savez(path, **arrays),
    "compressed npz": lambda path, arrays: np.savez_compressed(path, **arrays),
    "MAT 5": lambda path, arrays: savemat(path, arrays),
    "MAT 5 compressed": lambda path, arrays: savemat(path, arrays, do_compression=True, oned_as="column"),
    "MAT 7.3": write_mat73,
    "HDF5": write_hdf5,
}


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("transposed", [False, True])
def test_matrices_become_a_column_per_joint(name: str, transposed: bool, tmp_path: Path) -> None:
    path = tmp_path / f"data.{'npz' if 'npz' in name else 'h5' if name == 'HDF5' else 'mat'}"
    arrays = {"time": TIME, "position": MATRIX.T if transposed else MATRIX, "mode": TIME > 0.2, "Ts": np.array(0.1)}
    WRITERS[name](path, arrays)
    table = read(path)
    assert set(table.columns) == {"time", "position_1", "position_2", "mode"}
    np.testing.assert_array_equal(table.column("time"), TIME)
    np.testing.assert_array_equal(table.column("position_2"), MATRIX[:, 1])
    np.testing.assert_array_equal(table.column("mode"), [0, 0, 0, 1, 1])
    assert "Ts" in table.notes[0]
    assert table.units == (dict.fromkeys(("position_1", "position_2"), "deg") if name == "HDF5" else {})


def test_structures_of_mat_files_are_searched(tmp_path: Path) -> None:
    savemat(tmp_path / "a.mat", {"log": {"t": TIME, "axis": {"q": MATRIX, "name": "left"}}})
    assert list(read(tmp_path / "a.mat").columns) == ["log.t", "log.axis.q_1", "log.axis.q_2"]


def test_fields_of_a_table_in_hdf5_are_columns(tmp_path: Path) -> None:
    rows = np.zeros(5, dtype=[("t", "f8"), ("q", "f4")])
    rows["t"] = TIME
    with h5py.File(tmp_path / "a.hdf5", "w") as file:
        file["run/log"] = rows
        file["run/name"] = "arm"
    assert list(read(tmp_path / "a.hdf5").columns) == ["run.log.t", "run.log.q"]


@pytest.mark.parametrize("suffix", ["parquet", "feather"])
def test_columns_of_arrow_files(suffix: str, tmp_path: Path) -> None:
    columns = {
        "stamp": pyarrow.array([0, 250_000_000, None], pyarrow.timestamp("ns", "UTC")),
        "q": [1.0, None, 3.0],
        "count": [1, None, 3],
        "both": [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]],
        "state": ["on", "off", None],
    }
    write = parquet.write_table if suffix == "parquet" else feather.write_feather
    write(pyarrow.table(columns), tmp_path / f"a.{suffix}")
    table = read(tmp_path / f"a.{suffix}")
    np.testing.assert_array_equal(table.column("stamp"), [0, 0.25, np.nan])
    np.testing.assert_array_equal(table.column("q"), [1, np.nan, 3])
    np.testing.assert_array_equal(table.column("count"), [1, np.nan, 3])
    np.testing.assert_array_equal(table.column("both_2"), [2, 4, 6])
    assert table.start == "1970-01-01T00:00:00.000+00:00"
    with pytest.raises(BadInput, match="column 'state': numbers expected, text found"):
        table.column("state")


@pytest.mark.parametrize("name", ["data.npz", "data.mat", "data.parquet", "data73.mat", "data.h5", "data.feather"])
def test_damaged_files_are_refused(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    if name.endswith("npz"):
        np.savez(path, time=TIME)
    elif name.endswith("parquet"):
        parquet.write_table(pyarrow.table({"t": TIME}), path)
    elif name.endswith("feather"):
        feather.write_feather(pyarrow.table({"t": TIME}), path)
    elif name.endswith("h5"):
        write_hdf5(path, {"time": TIME, "position": TIME})
    elif "73" in name:
        write_mat73(path, {"time": TIME})
    else:
        savemat(path, {"time": TIME})
    whole = path.read_bytes()
    for size in (8, 150, 600, len(whole) // 2, len(whole) - 5):
        path.write_bytes(whole[:size])
        try:
            table = read(path)
        except BadInput:
            continue
        assert table.count in (0, len(TIME))


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
