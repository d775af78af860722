"""Rows that say in parts what holds at one time: a row for each joint, or for each topic, made one row."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.errors import BadInput
from recordings.importing import clock
from recordings.importing.columns import DRIVES, kind
from recordings.importing.mapping import joint_quantity
from recordings.importing.table import JOINT_QUANTITIES, Table, words_of
from recordings.interpolation import interpolate_within_gaps
from recordings.recording import Bools, Floats

_KEYS = "joint axis motor drive name channel signal variable quantity node id achse gelenk antrieb"
_NUMBERS = "number nr no index nummer"
"""Last words of the name of a column that says which joint, or which quantity, a row is of: joint, axis number."""
_VALUES = ("value", "values", "val", "wert", "data", "reading")
"""A single column of values that is called so adds nothing to the name of the key."""
_MOST_JOINTS = 64
"""A column with more distinct values is none of joints."""
_MOST_SHARED = 0.1
"""Columns of two topics have at most this share of their rows in common."""
_MIN_TURNS, _LEAST_TURNS = 0.1, 10
"""Rows of topics stand between each other if they take turns in this share of the rows, and so often."""
_MOST_TIMES = 0.75
"""In a long table, the distinct times are at most this share of the rows: two joints make a half."""


def widened(table: Table) -> Table:
    """Put the joints of a long table side by side: columns VALUE_KEY, such as `position_left`, one per joint.

    Joints with instants of their own are interpolated at those of the first. A table that is not long is returned as
    it is.

    Raises:
        BadInput: a joint stands twice at one time.
    """
    wide = any(map(joint_quantity, table.columns))
    name = next((column for column in table.columns if clock.is_called_time(table, column)), None)
    if wide or name is None or len(table.columns[name]) < 2 or not np.isfinite(table.columns[name]).all():
        return table
    time = table.columns[name]
    candidates = dict(_candidates(table, name))
    keys = _keys(table, time, candidates)
    values = [column for column in table.columns if column not in (name, *keys)]
    if not keys or not values:
        return table
    texts, place = _texts(candidates, keys)
    shared = _repeats(time)
    instants = np.unique(time) if shared else np.sort(time[place == 0])
    columns: dict[str, Floats] = {name: instants}
    units = {name: table.units[name]} if name in table.units else {}
    for column in values:
        for k, text in enumerate(texts):
            of = text if len(values) == 1 and column.lower() in _VALUES else f"{column}_{text}"
            columns[of] = _placed(instants, time[place == k], table.columns[column][place == k], shared=shared)
            if column in table.units:
                units[of] = table.units[column]
    own = "" if shared else f" at the times of {texts[0]}, the others interpolated"
    note = f"a row for each time and {' and '.join(keys)}: made a column for each ({', '.join(texts)}){own}"
    invalid = {column: why for column, why in table.invalid.items() if column not in keys}
    notes = (*table.notes, note)
    return replace(table, columns=columns, units=units, invalid=invalid, first_line=None, labels={}, notes=notes)


def merged(table: Table) -> Table:
    """Put the rows of several topics, which stand between each other with gaps in place of the others, together.

    What is not of the positions' topic is interpolated at its times. A table of one topic is returned as it is.
    """
    known = {name: np.isfinite(values) for name, values in table.columns.items()}
    topics: dict[bytes, list[str]] = {}
    for name, rows in known.items():
        if rows.any() and not rows.all():
            topics.setdefault(rows.tobytes(), []).append(name)
    base = next((names for names in topics.values() if any(kind(table, name) == "position" for name in names)), None)
    if base is None or len(topics) < 2:
        return table
    rows = known[base[0]]
    if np.count_nonzero(np.diff(rows)) < max(_LEAST_TURNS, _MIN_TURNS * len(rows)):
        return table
    if (guess := clock.find(table.of_rows(np.flatnonzero(rows)))) is None:
        return table
    others = [name for names in topics.values() if names is not base for name in names]
    apart = [
        name for name in others if (known[name] & rows).sum() <= _MOST_SHARED * min(known[name].sum(), rows.sum())
    ]
    if not any(kind(table, name) in DRIVES for name in apart):
        return table
    time = np.sum([table.columns[name] * unit.factor for name, unit in guess.source.parts], axis=0)
    columns = dict(table.columns)
    for name in apart:
        columns[name] = interpolate_within_gaps(time, time[known[name]], table.columns[name][known[name]])
    note = (
        f"rows of several topics stand between each other: {', '.join(apart)} interpolated at the times of {base[0]}"
    )
    of_base = replace(table, columns=columns, notes=(*table.notes, note)).of_rows(np.flatnonzero(rows))
    return replace(of_base, first_line=None)


def _candidates(table: Table, time: str) -> Iterator[tuple[str, NDArray[Any]]]:
    """Columns (n,) that may say which joint, or which quantity, a row is of: quantities, then text, then numbers."""
    texts = {name: cells for name, cells in table.labels.items() if 1 < len(set(cells)) <= _MOST_JOINTS}
    yield from sorted(texts.items(), key=lambda item: not set(item[1]) <= set(JOINT_QUANTITIES))
    for name, values in table.columns.items():
        if name != time and _says_key(name) and np.isfinite(values).all() and (values == np.rint(values)).all():
            distinct = np.unique(values)
            if 1 < len(distinct) <= _MOST_JOINTS:
                yield name, np.searchsorted(distinct, values) + 1  # joints are counted from 1


def _keys(table: Table, time: Floats, candidates: dict[str, NDArray[Any]]) -> tuple[str, ...]:
    """The candidates that, with the time, tell the rows apart; empty if the table is not long."""
    if not _repeats(time):
        return next(((name,) for name, key in candidates.items() if _says_key(name) and _alternates(time, key)), ())
    choices = [*((name,) for name in candidates), *combinations(candidates, 2)]
    for names in choices:
        if not _twice(time, candidates, names).any():
            return names
    named = next((names for names in reversed(choices) if all(map(_says_key, names))), None)
    if named is None:
        return ()
    row = int(np.argmax(_twice(time, candidates, named)))
    which = ", ".join(f"{name} {candidates[name][row]}" for name in named)
    raise BadInput(
        f"{table.location(row)}: one row for each time and {' and '.join(named)} expected, {which} at {time[row]:g} "
        "twice found; remove one of them"
    )


def _says_key(name: str) -> bool:
    *before, last = words_of(name) or [""]
    keys = set(_KEYS.split())
    return last in keys or (last in _NUMBERS.split() and not keys.isdisjoint(before))


def _repeats(time: Floats) -> bool:
    return len(np.unique(time)) <= _MOST_TIMES * len(time)


def _alternates(time: Floats, key: NDArray[Any]) -> bool:
    """Whether rows of several joints, each with times of its own, are mixed or stand one below the other."""
    mixed = np.count_nonzero(key[1:] != key[:-1]) >= len(key) / 2
    return bool(mixed or (np.diff(time) <= 0).any()) and all(
        (np.diff(time[key == value]) > 0).all() for value in np.unique(key)
    )


def _twice(time: Floats, candidates: dict[str, NDArray[Any]], names: Sequence[str]) -> Bools:
    """Whether a row (n,) repeats the time and the keys `names` of an earlier one."""
    _, place = _texts(candidates, names)
    pairs = np.column_stack([np.unique(time, return_inverse=True)[1], place])
    repeated = np.ones(len(time), bool)
    repeated[np.unique(pairs, axis=0, return_index=True)[1]] = False
    return repeated


def _texts(candidates: dict[str, NDArray[Any]], names: Sequence[str]) -> tuple[list[str], NDArray[np.intp]]:
    """Joints in the order in which they first appear, and that of each row (n,)."""
    joined = np.array(["_".join(map(str, row)) for row in zip(*(candidates[name] for name in names), strict=True)])
    texts, first, place = np.unique(joined, return_index=True, return_inverse=True)
    order = np.argsort(first)
    return texts[order].tolist(), np.argsort(order)[place]


def _placed(instants: Floats, time: Floats, values: Floats, *, shared: bool) -> Floats:
    """The `values` (k,) of one joint at the `instants` (n,); NaN where it has none."""
    order = np.argsort(time, kind="stable")
    if not shared:
        return interpolate_within_gaps(instants, time[order], values[order])
    placed = np.full(len(instants), np.nan)
    placed[np.searchsorted(instants, time)] = values
    return placed
