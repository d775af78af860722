"""Tables of named arrays, as NPZ, MAT, HDF5, TDMS, MDF, Parquet and Feather files hold them."""

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.columns import numbered
from recordings.importing.table import Table
from recordings.importing.units import is_none, split_header
from recordings.limits import check_columns
from recordings.recording import Floats


def table_of_arrow(path: Path, content: Any) -> Table:
    """Make a table of an Arrow table `content`; a column of lists of one length becomes a column per element."""
    columns = {name: content[name].combine_chunks() for name in content.column_names}
    arrays = {name: column.to_numpy(zero_copy_only=False) for name, column in columns.items()}
    return table_of_arrays(path, arrays)


def table_of_arrays(path: Path, arrays: Mapping[str, NDArray[Any]], units: Mapping[str, str] | None = None) -> Table:
    """Make a table of arrays: a matrix (n, k) or (k, n) gives k columns NAME_1 ... NAME_k.

    Arrays of another length than the others are left out, and noted; text becomes labels.
    """
    check_columns(len(arrays), str(path))
    stacked = {name: _stacked(np.squeeze(array)) for name, array in arrays.items()}
    count = _rows(stacked)
    check_columns(max((array.size // max(count, 1) for array in stacked.values()), default=0), str(path))
    columns: dict[str, Floats] = {}
    invalid: dict[str, str] = {}
    stated: dict[str, str] = {}
    labels: dict[str, NDArray[Any]] = {}
    start, other, left_out = None, [], []
    for name, array in stacked.items():
        if array.ndim not in (1, 2) or count not in array.shape:
            other.append(name)
            left_out.append(f"{name} of shape {array.shape}" + (f" and not {count} values long" if count else ""))
        elif array.dtype.kind == "M":
            columns[name], start = _seconds(array)
            stated[name] = "s"
        elif array.dtype.kind not in "fiub":
            kind = "text" if array.dtype.kind in "OSUT" else array.dtype.name
            left_out.append(f"{name} holds {kind}")
            invalid[name] = f"{path}, column {name!r}: numbers expected, {kind} found; export it as numbers"
            if kind == "text" and array.ndim == 1:
                labels[name] = np.array([_text(value) for value in array])
        else:
            rows = array.astype(float) if len(array) == count else array.astype(float).T
            named = {name: rows} if rows.ndim == 1 else numbered(name, rows)
            columns |= named
            if not is_none(unit := (units or {}).get(name, split_header(name)[1])):
                stated |= dict.fromkeys(named, unit)
    notes = (f"left out, because not {count} values long: {', '.join(other)}",) if other else ()
    return Table(
        path,
        columns,
        stated,
        start=start,
        invalid=invalid,
        labels=labels,
        left_out=tuple(left_out),
        notes=notes,
    )


def _text(value: Any) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else "" if value is None else str(value)


def _stacked(array: NDArray[Any]) -> NDArray[Any]:
    """A matrix of an array of equally long lists, numbers of an array of objects; anything else as it is."""
    if array.dtype.kind != "O" or not array.size:
        return array
    try:
        return np.array(array.tolist(), dtype=float)
    except (TypeError, ValueError):
        return array


def _rows(arrays: Mapping[str, NDArray[Any]]) -> int:
    """Number of samples: the most frequent length of the vectors, or else the longest axis."""
    vectors = Counter(len(array) for array in arrays.values() if array.ndim == 1 and len(array) > 1)
    if vectors:
        most = max(vectors.values())
        return max(length for length, number in vectors.items() if number == most)
    return max((length for array in arrays.values() if array.ndim == 2 for length in array.shape), default=0)


def _seconds(array: NDArray[Any]) -> tuple[Floats, str | None]:
    """Seconds (n,) since the first date, NaN where there is none, and that date."""
    stamp = array.astype("datetime64[ns]")
    known = ~np.isnat(stamp)
    if not known.any():
        return np.full(len(array), np.nan), None
    first = stamp[known][0]
    seconds = np.where(known, (stamp - first).astype(np.int64) / 1e9, np.nan)
    return seconds, f"{np.datetime_as_string(first, unit='ms')}+00:00"
