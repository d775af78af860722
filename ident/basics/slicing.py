"""Cut data along time: all arrays of a dataclass, and of what it contains, at once."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

_T = TypeVar("_T")


def along_time(data: _T, index: slice | NDArray[Any]) -> _T:
    """Return `data` with `index` applied to the first axis of every array in it.

    data: an array, a mapping, or a dataclass whose arrays all have time as their first axis. Other values are kept.
    """
    return _cut(data, index)


def _cut(value: Any, index: slice | NDArray[Any]) -> Any:
    if isinstance(value, np.ndarray):
        return value[index]
    if isinstance(value, Mapping):
        return {name: _cut(entry, index) for name, entry in value.items()}
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{field.name: _cut(getattr(value, field.name), index) for field in fields(value)})
    return value
