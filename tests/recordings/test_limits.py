"""Files of strangers take no more memory than what they say justifies."""

import json
import zlib
from collections import deque
from collections.abc import Callable
from pathlib import Path

import h5py
import lz4.frame
import numpy as np
import pyarrow
import pytest
import zstandard
from mcap.records import Chunk
from pyarrow import parquet
from scipy.io import savemat

from recordings.chunk import unpacked
from recordings.errors import BadInput
from recordings.importing import formats
from recordings.limits import Allowance, json_object

ZEROS = 100_000_000
"""Bytes that a small file unpacks to."""


def chunk(data: bytes, packed: bytes, compression: str = "zstd", **changes: int) -> Chunk:
    sizes = {"uncompressed_size": len(data), "uncompressed_crc": zlib.crc32(data)} | changes
    return Chunk(compression=compression, data=packed, message_start_time=0, message_end_time=0, **sizes)


@pytest.mark.parametrize("compression", ["", "zstd", "lz4"])
def test_chunk_holds_what_it_declares(compression: str) -> None:
    data = bytes(range(256)) * 100
    packed = {"": bytes, "zstd": zstandard.compress, "lz4": lz4.frame.compress}[compression](data)
    assert unpacked(chunk(data, packed, compression)) == data
    for changes in ({"uncompressed_size": 100}, {"uncompressed_size": 10**5}, {"uncompressed_crc": 1}):
        with pytest.raises(ValueError, match="does not hold what it declares"):
            unpacked(chunk(data, packed, compression, **changes))


def test_chunk_that_becomes_far_larger_is_not_unpacked() -> None:
    packed = zstandard.compress(bytes(1000))
    with pytest.raises(ValueError, match="more than 32 times its size"):
        unpacked(chunk(b"", packed, uncompressed_size=2**40))
    allowance = Allowance()
    with pytest.raises(ValueError, match="more than 32 times its size"):
        deque((unpacked(chunk(bytes(1000), packed), allowance) for _ in range(10**6)), maxlen=0)


def hdf5(path: Path) -> None:
    with h5py.File(path, "w", userblock_size=512) as file:
        file.create_dataset("time", (ZEROS,), np.uint8, chunks=(10**6,), compression="gzip")
    with path.open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file")


BOMBS: dict[str, Callable[[Path], None]] = {
    "a.npz": lambda path: np.savez_compressed(path, time=np.zeros(ZEROS, np.uint8)),
    "a.mat": lambda path: savemat(path, {"time": np.zeros(ZEROS, np.uint8)}, do_compression=True),
    "v73.mat": hdf5,
    "a.parquet": lambda path: parquet.write_table(pyarrow.table({"time": np.zeros(ZEROS // 8)}), path),
}


@pytest.mark.parametrize("name", BOMBS)
def test_table_that_becomes_far_larger_is_refused(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    BOMBS[name](path)
    assert path.stat().st_size < 10**6
    with pytest.raises(BadInput, match="more than 32 times its size"):
        formats.read(path)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("[" * 10_000, "nested too deeply"),
        ('{"a":' * 40 + "1" + "}" * 40, "nested too deeply"),
        ('{"a": ' + "1" * 10_000 + "}", "is not valid JSON.*digits"),
        ('{"a": [1, ' + "1" * 200 + "]}", "'a.1': a number of at most 1e.100"),
        ('{"a": NaN}', "'a': .*found nan"),
        ("[]", "a JSON object expected"),
        ("x" * 9_000_000, "at most 8000 kB"),
    ],
)
def test_json_beyond_the_limits_is_refused(tmp_path: Path, text: str, reason: str) -> None:
    path = tmp_path / "a.json"
    path.write_text(text)
    with pytest.raises(BadInput, match=reason):
        json_object(path, "file")
    path.write_text(json.dumps({"a": [1, 1e99]}))
    assert json_object(path, "file") == {"a": [1, 1e99]}


def test_text_table_with_endless_lines_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("a," * 40_000)
    with pytest.raises(BadInput, match="lines of at most 50000 characters"):
        formats.read(path)
    path.write_text("\n".join(["1," * 3000 + "1"] * 3))
    with pytest.raises(BadInput, match="at most 2000 columns expected, 3001 found"):
        formats.read(path)
