"""Cut and join data along time: all arrays of a dataclass, and of what it contains, at once."""

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

_T = TypeVar("_T")


def along_time(data: _T, index: slice | NDArray[Any]) -> _T:
    """Return `data` with `index` applied to the first axis of every array in it.

    data: an array, a mapping, or a dataclass whose arrays all have time as their first axis. Other values are kept.
    """
    value: Any = data
    if isinstance(value, np.ndarray):
        value = value[index]
    elif isinstance(value, Mapping):
        value = {name: along_time(entry, index) for name, entry in value.items()}
    elif is_dataclass(value) and not isinstance(value, type):
        value = replace(value, **{each.name: along_time(getattr(value, each.name), index) for each in fields(value)})
    return cast(_T, value)


def concatenated(parts: Sequence[_T]) -> _T:
    """Join data along time: every array in the first of the `parts` goes on with those of the others.

    What is None, or has no such name, in one of them is left out. Values other than arrays are those of the first.
    """
    several: Sequence[Any] = parts
    first = joined = several[0]
    if any(part is None for part in several):
        joined = None
    elif isinstance(first, np.ndarray):
        joined = np.concatenate(several)
    elif isinstance(first, Mapping):
        names = [name for name in first if all(name in part for part in several)]
        joined = {name: concatenated([part[name] for part in several]) for name in names}
    elif is_dataclass(first) and not isinstance(first, type):
        names = [each.name for each in fields(first)]
        joined = replace(first, **{name: concatenated([getattr(part, name) for part in several]) for name in names})
    return cast(_T, joined)
