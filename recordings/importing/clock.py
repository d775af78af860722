"""What is time in a table: what increases in steps that nearly repeat.

A counter of rows or messages does so, too, and is never taken for time. The unit comes from the file, or from the
rate where one unit alone gives a rate that machines have; otherwise it is asked for.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from recordings.data_problems import DataProblem
from recordings.errors import BadInput
from recordings.importing.mapping import Source, as_mapped, or_guess
from recordings.importing.table import Table, words_of
from recordings.importing.units import NO_UNIT, Unit, check_dimension, is_none, parse
from recordings.recording import Floats, Ints

_WORDS = "time t timestamp stamp zeit sec secs seconds clock duration ms us ns nsec nsecs nanosec"
UNITS = {text: unit for text in ("s", "ms", "us", "ns") if (unit := parse(text))}
RATES = (0.999, 49e3)
"""Sampling rates that machines have [Hz]: they tell the unit of time."""
_DATES = (1e9, 4e9)
"""Times [s] between these are counted from 1970, as ROS and Unix do: 2001 to 2096."""
_MAX_TIME = 2**31
"""Largest time that a ROS time stamp holds [s]."""
_MOSTLY = 0.9
"""A time increases in more than this share of its steps."""
_NEAR = 0.5
"""Steps that nearly repeat differ from their median by less than this share of it."""
_AT_ONCE = 0.1
"""Share of the usual step below which a row follows another one at once."""
_FEW = 10
"""Rows that may follow others at once by chance."""
_SET_BACK = 1e-3
"""Share of rows at which a clock is set back; more of them are rows out of order."""


@dataclass(frozen=True)
class TimeGuess:
    """Column of time; without a unit, those that give a rate that machines have are `possible`."""

    source: Source
    why: str
    possible: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Clock:
    """Time of the rows that are kept."""

    table: Table
    stamp: Ints
    """(n,) [ns] from the first row."""
    epoch: float | None
    """Time of the first row since 1970 [s], where time counts from there."""
    problems: tuple[DataProblem, ...] = ()
    """What was healed."""


def find(table: Table) -> TimeGuess | None:
    """The time of `table`: a column of that name or unit, two columns that make one, or any that is like time."""
    if "time" in table.columns:
        return _with_unit(table, "time", table.columns["time"])
    likeness = {name: share for name in table.columns if (share := _increases(table.columns[name])) > _MOSTLY}
    called = [name for name in likeness if is_called_time(table, name)]
    if pair := next(_pairs(table), None):
        return TimeGuess(pair, f"{' and '.join(pair.columns)} make one time")
    regular = [name for name, share in likeness.items() if share == 1 and _repeats(table.columns[name])]
    others = [
        name for name in regular if not is_counter(table.columns[name]) and parse(table.units.get(name, "")) is None
    ]
    name = max(called, key=lambda name: likeness[name], default=next(iter(others), None))
    return None if name is None else _with_unit(table, name, table.columns[name])


def is_called_time(table: Table, name: str) -> bool:
    """Whether name or unit of a column say that it is a time."""
    unit = parse(table.units.get(name, ""))
    return unit.dimension == "time" if unit else not set(_WORDS.split()).isdisjoint(words_of(name))


def is_counter(values: Floats) -> bool:
    """Whether `values` (n,) count rows: whole numbers, each one more than the one before."""
    return len(values) > 1 and bool((np.diff(values) == 1).all() and float(values[0]).is_integer())


def _increases(values: Floats) -> float:
    """Share of the steps of `values` (n,) that increase; a counter that wraps does, and one that stands twice."""
    steps = np.diff(values) if np.isfinite(values).all() else np.zeros(0)
    moving = steps[steps != 0]
    return float((moving > 0).mean()) if len(moving) and 2 * len(moving) + 1 >= len(steps) else 0.0


def _repeats(values: Floats) -> bool:
    steps = np.diff(values)
    median = np.median(steps)
    return bool((np.abs(steps - median) < _NEAR * median).mean() > _MOSTLY)


def _pairs(table: Table) -> Iterator[Source]:
    """Neighbouring columns of whole numbers of which the second counts parts of the first, as sec and nanosec do."""
    whole = {name: values for name, values in table.columns.items() if len(values) > 1 and (values % 1 == 0).all()}
    for (name, seconds), (part, parts) in pairwise(whole.items()):
        for scale in list(UNITS.values())[1:]:
            within = ((parts >= 0) & (parts * scale.factor < 1)).all()
            if within and _named_unit(table, name).factor == 1.0 and _carries(seconds, parts, scale.factor):
                yield Source(name, UNITS["s"], plus=Source(part, scale))


def _carries(seconds: Floats, parts: Floats, scale: float) -> bool:
    """Whether `parts` (n,) begin anew in each of the `seconds` (n,), so that the steps of their sum nearly repeat."""
    time = (seconds - seconds[0]) + parts * scale
    carried = np.diff(seconds) > 0
    usual = np.median(np.diff(time))
    near = np.abs(np.diff(time)[carried] - usual) < _NEAR * usual
    return bool(0 < carried.mean() < _NEAR and _increases(time) > _MOSTLY and near.mean() > _NEAR)


def _named_unit(table: Table, name: str) -> Unit:
    """Unit of time that the file states, or that is a word of the name; seconds without either."""
    stated = parse(table.units.get(name, ""))
    words = [word for word in words_of(name) if word not in ("s", "min")]
    units = [unit for word in words if (unit := parse(word)) and unit.dimension == "time"]
    return stated or next(iter(units), UNITS["s"] if name.endswith("_s") else NO_UNIT)


def _with_unit(table: Table, name: str, values: Floats) -> TimeGuess:
    unit = _named_unit(table, name)
    if unit.dimension is not None:
        where = "file" if name in table.units else "name"
        return TimeGuess(Source(name, unit), f"unit {unit.text} in the {where}")
    unknown = table.units.get(name, "")
    if not is_none(unknown):
        return TimeGuess(Source(name, NO_UNIT), f"unit {unknown!r} is not known", tuple(UNITS))
    first, step = float(values[0]), float(np.median(np.diff(np.unique(values))))
    since_1970 = [text for text, unit in UNITS.items() if _DATES[0] < first * unit.factor < _DATES[1]]
    fitting = [text for text, unit in UNITS.items() if step > 0 and RATES[0] <= 1 / (step * unit.factor) <= RATES[1]]
    if name == "time" and "s" in fitting:
        return TimeGuess(Source(name, NO_UNIT), "name; SI unit")
    for texts, why in ((since_1970, "counts from 1970"), (fitting, f"increases; steps of {step:g}")):
        if len(texts) == 1:
            unit = UNITS[texts[0]]
            rate = 1 / (step * unit.factor) if step else np.inf
            return TimeGuess(Source(name, unit), f"{why} {texts[0]} make {rate:.4g} Hz")
    return TimeGuess(Source(name, NO_UNIT), f"increases; steps of {step:g}", tuple(fitting) or tuple(UNITS))


def read(table: Table, source: Source | None) -> Clock:
    """Time of the rows of `table`: a clock that starts late, wraps or is set back is healed, and named.

    Raises:
        BadInput: there is no time, it has gaps, or rows are out of order or stand twice with different values.
    """
    if source is None:
        raise BadInput(
            f"{table.path}: a column 'time' expected, {table.listed()} found; say which it is, as in "
            f"{as_mapped('time', 'COLUMN:ms')}{or_guess(table)}"
        )
    time, offset = _in_seconds(table, source)
    if len(time) < 2:
        raise BadInput(f"{table.path}: at least two samples expected, {len(time)} found; record more")
    first = _before_the_clock(time)
    problems = []
    if first:
        table_rows = np.arange(first, len(time))
        why = f"{table.location(0, source.column)}: time 0 before the clock ran; {first} rows left out"
        problems.append(_healed("clock-set-back", why))
        table, time = table.of_rows(table_rows), time[first:]
    time, healed = _continued(table, source, time)
    if len(rows := _once(table, source, time)) < len(time):
        why = f"{len(time) - len(rows)} rows stand twice: all but the first of each are left out"
        problems.append(_healed("repeated-rows", f"{table.path.name}: {why}"))
        table, time = table.of_rows(rows), time[rows]
    if abs(time[-1] - time[0]) >= _MAX_TIME:
        raise BadInput(
            f"{table.path}, column {source.column!r}: times within {_MAX_TIME} s expected, {time[-1] - time[0]:g} s "
            f"found; say the unit, as in {as_mapped('time', f'{source.column}:ns')}"
        )
    # Whole seconds are split off, so that times since 1970 keep the full resolution of their fractions.
    seconds = np.floor(time)
    stamp = (seconds - seconds[0]).astype(np.int64) * 10**9 + np.rint((time - seconds) * 1e9).astype(np.int64)
    stamp -= stamp[0]
    _check_increasing(table, source, stamp)
    epoch = offset + float(time[0])
    return Clock(table, stamp, epoch if _DATES[0] < epoch < _DATES[1] else None, (*problems, *healed))


def _in_seconds(table: Table, source: Source) -> tuple[Floats, float]:
    """Times (n,) [s] of one column or the sum of two; of two, counted from an offset that is given beside."""
    parts = [source, source.plus] if source.plus else [source]
    columns = []
    for part in parts:
        check_dimension(part.unit, "time", prismatic=False, where=f"{table.path}, column {part.column!r}")
        values = table.column(part.column)
        if np.isnan(values).any():
            place = table.location(int(np.argmax(np.isnan(values))), part.column)
            raise BadInput(f"{place}: a time expected, none found; complete or remove the row")
        columns.append(values * part.unit.factor)
    offset = float(columns[0][0]) if source.plus and len(columns[0]) else 0.0
    return columns[0] - offset + (columns[1] if source.plus else 0.0), offset


def _before_the_clock(time: Floats) -> int:
    """Number of first rows whose time is 0 while all others are counted from far away, as from 1970."""
    first = int(np.argmax(time != time[0]))
    rest = time[first:]
    far = len(rest) > 1 and first and abs(rest[0] - time[0]) > max(_DATES[0] / 2, 2 * np.ptp(rest))
    return first if far else 0


def _continued(table: Table, source: Source, time: Floats) -> tuple[Floats, tuple[DataProblem, ...]]:
    """Time without the places at which it runs backwards because a counter wraps or a clock is set back."""
    steps = np.diff(time)
    back = np.flatnonzero(steps < 0)
    if not len(back) or not (steps > 0).any():
        return time, ()
    typical = float(np.median(steps[steps > 0]))
    raw = table.column(source.column)
    for bits in (16, 32):
        turn = 2**bits * source.unit.factor
        if raw.min() >= 0 and raw.max() < 2**bits and (np.abs(steps[back] + turn - typical) < turn / 8).all():
            why = f"{_rows(table, source, back)}: a counter of {bits} bits starts anew; it was continued"
            return time + np.concatenate([[0.0], np.cumsum(steps < 0)]) * turn, (_healed("counter-wrapped", why),)
    stray = (time[back + 1] > time[np.maximum(back - 1, 0)]).any()  # one wrong time, or two rows exchanged
    if stray or len(back) > max(1, _SET_BACK * len(time)) or _out_of_order(time, typical):
        return time, ()
    shift = np.zeros(len(time))
    shift[back + 1] = typical - steps[back]
    far = ", ".join(f"{-steps[k]:g} s" for k in back[:3])
    why = f"{_rows(table, source, back)}: the clock is set back by {far}; time goes on with the usual step"
    return time + np.cumsum(shift), (_healed("clock-set-back", why),)


def _out_of_order(time: Floats, typical: float) -> bool:
    """Whether the rows make an even time when they are sorted."""
    steps = np.diff(np.sort(time))
    return bool(steps.min() > _NEAR * typical and steps.max() <= np.diff(time).max())


def _once(table: Table, source: Source, time: Floats) -> Ints:
    """Rows (m,) without those that hold what the one before does, at the same time or at once beside the usual step.

    Rows that follow at once are kept where they are few, or others hold the same, too, as of a joint at rest.
    """
    steps = np.diff(time)
    at_once = steps < _AT_ONCE * np.quantile(steps, _MOSTLY)
    same = (steps >= 0) if at_once.any() else np.zeros(len(steps), bool)
    for name, values in table.columns.items() if same.any() else ():
        if name not in source.columns and not is_counter(values):
            same &= (values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))
    if (same & at_once).sum() < _FEW or same[~at_once].mean() >= _NEAR:
        at_once = steps == 0
    return np.flatnonzero(np.concatenate([[True], ~(same & at_once)]))


def _rows(table: Table, source: Source, rows: Ints) -> str:
    more = f" and {len(rows) - 1} more" if len(rows) > 1 else ""
    return f"{table.location(int(rows[0]) + 1, source.column)}{more}"


def _healed(kind: str, why: str) -> DataProblem:
    return DataProblem(kind=kind, joints=(), blocks=False, why=f"{why}.", remedy="Nothing is to be done.")


def _check_increasing(table: Table, source: Source, stamp: Ints) -> None:
    wrong = np.flatnonzero(np.diff(stamp) <= 0)
    if len(wrong):
        row, unit, raw = int(wrong[0]) + 1, source.unit.text or "s", table.column(source.column)
        raise BadInput(
            f"{table.location(row, source.column)}: a time after {float(raw[row - 1])!r} {unit} expected, "
            f"{float(raw[row])!r} found; sort the rows and remove those that stand twice, or count rows, as in "
            f"{as_mapped('time', 'row:s*0.001')} for one per ms"
        )
