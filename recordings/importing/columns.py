"""What the columns of a table hold: one decision for all columns of one kind.

Names, units and values say it. A decision is for the user to judge: it is printed with its reason and as the command
that says it explicitly. What they leave open is asked for.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from recordings.importing import clock
from recordings.importing.mapping import Source, joint_quantity
from recordings.importing.numerals import is_number
from recordings.importing.table import Table, words_of
from recordings.importing.units import NO_UNIT, Unit, in_name, is_none, parse, quantity_of
from recordings.recording import Floats

_WORDS = {
    "temperature": "temperature temp temperatur tmot",
    "current": "current cur curr i iq strom amps",
    "voltage": "voltage volt volts v u spannung",
    "effort": "torque effort tau tq trq moment drehmoment force kraft",
    "velocity": "velocity vel velo speed qd dq omega w drehzahl geschwindigkeit rpm qdot",
    "position": "position pos q angle theta winkel lage phi encoder enc angles positions",
}
_QUANTITY = {word: quantity for quantity, words in _WORDS.items() for word in words.split()}
_COMMAND = "cmd command commanded ref reference target demand demanded desired des soll sollwert setpoint set d"
_ACTUAL = "act actual ist istwert measured meas feedback fb state"
_OTHER = (
    "error err lag diff deviation limit max min fault status statusword acc acceleration qdd beschleunigung dc link "
    "bus supply abweichung schleppfehler schleppabstand following counter index frame sequence seq message msg "
    "platform tcp"
)
_MAX_ANGLE = 4 * np.pi
"""Joints seldom turn further [rad]: a larger range is in degrees."""
_MIN_COUNTS = 100
"""Whole numbers over a larger range are raw counts of a drive, whose unit the drive alone knows."""
_MAX_CURRENT = 200.0
"""A larger current is in mA."""
_MAX_SLOPE_ERROR = 0.1
"""Velocity is in the unit in which it is within this share of the derivative of position."""
_MOSTLY = 0.5
"""A column of numbers may hold some cells of text."""
_ASKED = "is for you to say, in --map"
DRIVES = ("effort", "current", "voltage")
"""What drives the motion, in the order in which it is preferred."""
_SI = {"velocity": "rad/s", "effort": "Nm", "current": "A", "voltage": "V", "temperature": "degC"}
_SPEEDS = ("rad/s", "deg/s", "rpm", "turns/s")


@dataclass(frozen=True)
class ColumnGuess:
    """What a column is taken for."""

    column: str
    target: str | None
    """Name of the quantity, such as position_1; None: kept as an extra channel."""
    source: Source | None
    """Its unit is unknown where something is asked for."""
    why: str
    asks: str = ""
    """What the user has to say; "" where all is known."""


@np.errstate(over="ignore", invalid="ignore")  # of values that the import refuses
def guess(table: Table) -> list[ColumnGuess]:
    """Guess what each column of `table` holds. The list is in the order of the columns."""
    lists = _lists(table)
    time = clock.find(table)
    guesses: dict[str, ColumnGuess] = {}
    for quantity in sorted(lists, key=lambda name: name == "velocity"):  # whose unit the position's may tell
        guesses |= _guessed(table, quantity, lists[quantity])
    if time is not None:
        guesses |= _time(table, time, guesses)
    if "velocity" in lists:
        guesses |= _velocities(table, guesses, lists["velocity"])
    if "cycle" in table.columns:
        guesses["cycle"] = ColumnGuess("cycle", "cycle", Source("cycle", NO_UNIT), "name")
    return [guesses.get(column) or _extra(table, column) for column in (*table.columns, *table.invalid)]


def kind(table: Table, name: str) -> str | None:
    """Quantity that the name or the unit of a column speaks for; None where neither does."""
    if named := joint_quantity(name):
        return named[0]
    words, unit = words_of(name), _stated(table, name)
    if _has(_OTHER, words) or (name in table.columns and clock.is_counter(table.columns[name])):
        return None
    quantity = quantity_of(unit) or next((_QUANTITY[word] for word in words if word in _QUANTITY), None)
    if unit.dimension in ("counts", "share") and quantity is None:
        quantity = "position" if unit.dimension == "counts" else "effort"
    if _has(_COMMAND, words):
        return "command" if quantity in ("position", None) else None
    return quantity


def _has(vocabulary: str, words: Sequence[str]) -> bool:
    return not set(vocabulary.split()).isdisjoint(words)


def _lists(table: Table) -> dict[str, list[str]]:
    """Columns of each quantity in the order of the joints."""
    named: dict[str, dict[int, str]] = {}
    for name in (*table.columns, *table.invalid):
        if of_joint := joint_quantity(name):
            named.setdefault(of_joint[0], {})[of_joint[1]] = name
    result = {quantity: [columns[k] for k in sorted(columns)] for quantity, columns in named.items()}
    groups: dict[str, list[list[str]]] = {}
    for (quantity, _), columns in _by_stem(table).items():
        groups.setdefault(quantity, []).append(_numbered(columns))
    for quantity, lists in groups.items():
        if all(len(columns) == 1 for columns in lists):  # joints with names of their own: a_pos, b_pos
            groups[quantity] = [[columns[0] for columns in lists]]
    groups |= _whole(groups)
    if "position" not in result and "position" in groups:
        result["position"] = _best(groups["position"], None)
    dof = len(result.get("position", ()))
    # One of what drives the motion, unless the file names it.
    drives = [] if set(DRIVES) & set(named) else [name for name in DRIVES if _best(groups.get(name, []), dof)][:1]
    for quantity in ("velocity", "command", "temperature", *drives):
        if quantity not in result and (columns := _best(groups.get(quantity, []), dof)):
            result[quantity] = _in_order(columns, result.get("position", []))
    return result


def _in_order(columns: list[str], positions: list[str]) -> list[str]:
    """The `columns` in the order of the joints' `positions`, where their names say which joint each is of."""

    def joint(name: str) -> tuple[str, ...]:
        return tuple(word for word in words_of(name) if word not in _QUANTITY)

    named = {joint(name): name for name in columns}
    ordered = [named.get(joint(name), "") for name in positions]
    return ordered if sorted(ordered) == sorted(columns) else columns


def _by_stem(table: Table) -> dict[tuple[str, tuple[str, ...]], list[str]]:
    """Columns by quantity and by the words of their names, without numbers; names that stand twice are two lists."""
    stems: dict[tuple[str, tuple[str, ...]], list[str]] = {}
    seen: Counter[str] = Counter()
    for name in (*table.columns, *_spoiled(table)):
        quantity = kind(table, name)
        if quantity is None or joint_quantity(name) or not np.isfinite(table.columns.get(name, np.ones(1))).any():
            continue
        base = _base(table, name)
        seen[base] += 1
        stem = (*(word for word in words_of(base) if not word.isdigit()), *["again"] * (seen[base] - 1))
        stems.setdefault((quantity, stem), []).append(name)
    return stems


def _spoiled(table: Table) -> list[str]:
    """Columns of numbers in which some cells hold text: they keep their place among the joints."""
    labels = {name: cells for name, cells in table.labels.items() if name in table.invalid}
    return [name for name, cells in labels.items() if np.mean([is_number(cell) for cell in cells]) > _MOSTLY]


def _base(table: Table, name: str) -> str:
    """Name as the file has it, where it stands there twice."""
    before, mark, _ = name.rpartition("#")
    return before if mark and before in (*table.columns, *table.invalid) else name


def _numbered(columns: list[str]) -> list[str]:
    """Sort columns of one stem by the numbers in their names."""
    numbers = [[int(word) for word in words_of(name.partition("#")[0]) if word.isdigit()] for name in columns]
    return [name for _, name in sorted(zip(numbers, columns, strict=True), key=lambda pair: pair[0])]


def _whole(groups: Mapping[str, list[list[str]]]) -> dict[str, list[list[str]]]:
    """Groups of one kind as one, where there are as many positions as torques, currents or voltages.

    Joints `elbow`, `wrist_1`, `wrist_2`, `wrist_3` are four, not the three that are numbered alike.
    """
    merged = {kind: [column for columns in lists for column in columns] for kind, lists in groups.items()}
    count = len(merged.get("position", ()))
    if not any(len(merged.get(drive, ())) == count for drive in DRIVES):
        return {}
    return {kind: [columns] for kind, columns in merged.items() if len(columns) == count}


def _best(lists: list[list[str]], dof: int | None) -> list[str]:
    """The largest group, or the one of `dof` columns; of several, one that is called actual, or else the first."""
    fitting = [columns for columns in lists if not dof or len(columns) == dof]
    return max(fitting, key=lambda c: (len(c), _has(_ACTUAL, words_of(c[0]))), default=[])


def _guessed(table: Table, quantity: str, columns: Sequence[str]) -> dict[str, ColumnGuess]:
    """Guesses for the columns of one quantity, which have one unit."""
    stated = {column: _stated(table, column) for column in columns}
    units = {unit.dimension: unit for unit in stated.values() if unit.dimension is not None}
    given = {column: table.units[column] for column in columns if not is_none(table.units.get(column, ""))}
    unknown = [column for column, unit in given.items() if not parse(unit)]
    text, why, asks = "", "name; SI unit", ""
    if unknown:
        why = f"unit {given[unknown[0]]!r} is not known"
        asks = f"{quantity}: the unit {given[unknown[0]]!r} of column {unknown[0]!r} is not known, so it {_ASKED}"
    elif units:
        text, why = next(iter(units.values())).text, f"unit of {quantity} in another column"
    elif not all(joint_quantity(column) for column in columns):
        text, why, asks = _likely_unit(quantity, [table.columns[name] for name in columns if name in table.columns])
    twice = [column for column in columns if _stands_twice(table, column)]
    if twice and quantity in ("position", *DRIVES):
        asks = f"{quantity}: {twice[0]!r} stands twice in the file, so which of them is meant {_ASKED}"
    made = {}
    for place, column in enumerate(columns, start=1):
        unit = stated[column]
        reason = f"unit {unit.text} in the {'file' if column in table.units else 'name'}"
        if unit.dimension is None:
            unit, reason = parse(text) or NO_UNIT, why
        target = column if joint_quantity(column) else f"{quantity}_{place}"
        spoiled = table.invalid.get(column, "")
        made[column] = ColumnGuess(column, target, Source(column, unit), spoiled or reason, spoiled or asks)
    return made


def _stands_twice(table: Table, column: str) -> bool:
    return any(_base(table, other) == column and other != column for other in (*table.columns, *table.invalid))


def _stated(table: Table, name: str) -> Unit:
    """Unit that the file states, or that stands in the name."""
    return parse(table.units.get(name, "")) or in_name(name) or NO_UNIT


def _likely_unit(quantity: str, columns: Sequence[Floats]) -> tuple[str, str, str]:
    """Unit that the values of all columns speak for, why, and what is to be asked for instead."""
    known = [values[np.isfinite(values)] for values in columns]
    known = [values for values in known if len(values)]
    extent = max((float(np.ptp(values)) for values in known), default=0.0)
    largest = max((float(np.abs(values).max()) for values in known), default=0.0)
    if extent > _MIN_COUNTS and all((values == np.rint(values)).all() for values in known):
        if quantity in ("position", "command"):
            return "counts", f"whole numbers over {extent:g}: counts of an encoder", ""
        why = f"whole numbers over {extent:g}: raw counts of a drive"
        return "", why, f"{quantity}: {why}, so its unit {_ASKED}"
    if quantity in ("position", "command"):
        if max(extent, largest) > _MAX_ANGLE:
            return "deg", f"up to {largest:.4g} over {extent:.4g} is too large for rad", ""
        return "rad", f"range {extent:.3g} fits rad", ""
    if quantity == "current" and largest > _MAX_CURRENT:
        return "mA", f"up to {largest:.4g} is too large for A", ""
    return _SI.get(quantity, ""), "name; unit not stated", ""


def _time(table: Table, found: clock.TimeGuess, guesses: Mapping[str, ColumnGuess]) -> dict[str, ColumnGuess]:
    """The time, whose unit speeds may tell where the rate does not."""
    source, why, asks = found.source, found.why, ""
    if found.possible:
        fitting = [text for text in found.possible if _fits_speeds(table, guesses, source.column, text)]
        if len(fitting) == 1:
            source = Source(source.column, clock.UNITS[fitting[0]])
            why = f"in {fitting[0]} the speeds are derivatives"
        else:
            asks = f"time: {source.column!r} {why}, which may be {' or '.join(found.possible)}, so its unit {_ASKED}"
            why = f"{why}: {' or '.join(found.possible)}"
    made = {source.column: ColumnGuess(source.column, "time", source, why, asks)}
    if source.plus:
        made[source.plus.column] = ColumnGuess(source.plus.column, None, None, f"time, with {source.column}")
    return made


def _fits_speeds(table: Table, guesses: Mapping[str, ColumnGuess], time: str, unit: str) -> bool:
    """Whether speeds, in the unit of the positions, are their derivatives if time is in `unit`."""
    slopes = _slopes(table, guesses, table.columns[time] * clock.UNITS[unit].factor)
    return bool(slopes) and all(abs(slope - 1) < _MAX_SLOPE_ERROR for slope in slopes)


def _slopes(table: Table, guesses: Mapping[str, ColumnGuess], time: Floats) -> list[float]:
    """How many times the derivative of its position [unit of that/s] each speed is."""
    by_target = {made.target: made.column for made in guesses.values() if made.column in table.columns}
    slopes = []
    for target, column in by_target.items():
        position = by_target.get((target or "").replace("velocity", "position"))
        if position in (None, column):
            continue
        derivative, velocity = np.gradient(table.columns[position], time), table.columns[column]
        known = np.isfinite(derivative) & np.isfinite(velocity)
        if size := float(velocity[known] @ velocity[known]):
            slopes.append(float(velocity[known] @ derivative[known]) / size)
    return slopes


def _velocities(table: Table, guesses: Mapping[str, ColumnGuess], columns: Sequence[str]) -> dict[str, ColumnGuess]:
    """Velocities without stated unit, in the one in which they are derivatives of the positions."""
    sources = {made.target: made.source for made in guesses.values()}
    time, position = sources.get("time"), sources.get("position_1")
    stated = any(_stated(table, name).dimension or joint_quantity(name) for name in columns)
    if stated or not time or not time.unit.dimension or not position or position.unit.dimension != "angle":
        return {}
    slopes = _slopes(table, guesses, table.columns[time.column] * time.unit.factor)
    for text in _SPEEDS:
        unit = parse(text) or NO_UNIT
        ratios = [slope * position.unit.factor / unit.factor for slope in slopes]
        if slopes and all(abs(ratio - 1) < _MAX_SLOPE_ERROR for ratio in ratios):
            why = f"in {text} it is the derivative of the position"
            return {name: replace(guesses[name], source=Source(name, unit), why=why) for name in columns}
    return {}


def _extra(table: Table, column: str) -> ColumnGuess:
    """A column that is kept as an extra channel, and why."""
    if column in table.invalid:
        return ColumnGuess(column, None, None, table.invalid[column])
    if np.isnan(table.columns[column]).all():
        return ColumnGuess(column, None, None, "no number in it")
    known = kind(table, column)
    why = f"{known}: another is taken, or joints lack it" if known else "name and unit say nothing known"
    return ColumnGuess(column, None, None, why)
