"""NPZ, MAT and Parquet: vectors, matrices, structures, dates."""

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pyarrow
import pytest
from pyarrow import parquet
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


WRITERS: dict[str, Callable[[Path, dict[str, np.ndarray]], None]] = {
    "npz": lambda path, arrays: np.savez(path, **arrays),
    "compressed npz": lambda path, arrays: np.savez_compressed(path, **arrays),
    "MAT 5": lambda path, arrays: savemat(path, arrays),
    "MAT 5 compressed": lambda path, arrays: savemat(path, arrays, do_compression=True, oned_as="column"),
    "MAT 7.3": write_mat73,
}


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("transposed", [False, True])
def test_matrices_become_a_column_per_joint(name: str, transposed: bool, tmp_path: Path) -> None:
    path = tmp_path / f"data.{'npz' if 'npz' in name else 'mat'}"
    arrays = {"time": TIME, "position": MATRIX.T if transposed else MATRIX, "mode": TIME > 0.2, "Ts": np.array(0.1)}
    WRITERS[name](path, arrays)
    table = read(path)
    assert set(table.columns) == {"time", "position_1", "position_2", "mode"}
    np.testing.assert_array_equal(table.column("time"), TIME)
    np.testing.assert_array_equal(table.column("position_2"), MATRIX[:, 1])
    np.testing.assert_array_equal(table.column("mode"), [0, 0, 0, 1, 1])
    assert "Ts" in table.notes[0]


def test_structures_of_mat_files_are_searched(tmp_path: Path) -> None:
    savemat(tmp_path / "a.mat", {"log": {"t": TIME, "axis": {"q": MATRIX, "name": "left"}}})
    assert list(read(tmp_path / "a.mat").columns) == ["log.t", "log.axis.q_1", "log.axis.q_2"]


def test_columns_of_parquet(tmp_path: Path) -> None:
    columns = {
        "stamp": pyarrow.array([0, 250_000_000, None], pyarrow.timestamp("ns", "UTC")),
        "q": [1.0, None, 3.0],
        "count": [1, None, 3],
        "both": [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]],
        "state": ["on", "off", None],
    }
    parquet.write_table(pyarrow.table(columns), tmp_path / "a.parquet")
    table = read(tmp_path / "a.parquet")
    np.testing.assert_array_equal(table.column("stamp"), [0, 0.25, np.nan])
    np.testing.assert_array_equal(table.column("q"), [1, np.nan, 3])
    np.testing.assert_array_equal(table.column("count"), [1, np.nan, 3])
    np.testing.assert_array_equal(table.column("both_2"), [2, 4, 6])
    assert table.start == "1970-01-01T00:00:00.000+00:00"
    with pytest.raises(BadInput, match="column 'state': numbers expected, text found"):
        table.column("state")


@pytest.mark.parametrize("name", ["data.npz", "data.mat", "data.parquet", "data73.mat"])
def test_damaged_files_are_refused(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    if name.endswith("npz"):
        np.savez(path, time=TIME)
    elif name.endswith("parquet"):
        parquet.write_table(pyarrow.table({"t": TIME}), path)
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
