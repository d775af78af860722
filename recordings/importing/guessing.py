"""Guess what the columns of a table hold, from their names, units and values.

A guess is for the user to judge: it is printed with its reason and as the command that says it explicitly.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from recordings.importing.mapping import Source, joint_quantity
from recordings.importing.table import Table
from recordings.importing.units import NO_UNIT, Unit, parse, quantity_of
from recordings.recording import Floats

_WORDS = {
    "time": "time t timestamp stamp zeit sec seconds clock",
    "temperature": "temperature temp temperatur tmot",
    "current": "current cur curr i iq strom amps",
    "voltage": "voltage volt volts v u spannung",
    "effort": "torque effort tau tq trq moment drehmoment force kraft",
    "velocity": "velocity vel speed qd dq omega w drehzahl geschwindigkeit rpm qdot",
    "position": "position pos q angle theta winkel lage phi encoder enc angles positions",
}
_QUANTITY = {word: quantity for quantity, words in _WORDS.items() for word in words.split()}
_COMMAND = "cmd command commanded ref reference target demand demanded desired des soll sollwert setpoint set"
_ACTUAL = "act actual ist istwert measured meas feedback fb state"
_OTHER = (
    "error err lag diff deviation limit max min fault status statusword acc acceleration qdd beschleunigung dc link "
    "bus supply abweichung schleppfehler schleppabstand following counter index frame sequence platform tcp"
)
_TOKEN = re.compile(r"[A-Z]+(?![a-zäöü])|[A-ZÄÖÜ]?[a-zäöü]+|\d+")

_RATES = (20.0, 20e3)
"""Sampling rates between which a recording of a drive lies [Hz]: they tell the unit of time."""
_MAX_ANGLE = 4 * np.pi
"""Joints seldom turn further [rad]: a larger range is in degrees or counts."""
_MIN_COUNTS = 1000
"""Whole numbers over a larger range are encoder counts."""
_MAX_CURRENT = 200.0
"""A larger current is in mA."""
_MOSTLY = 0.9
"""A time increases in more than this share of its steps."""
_MAX_SLOPE_ERROR = 0.1
"""Velocity is in the unit in which it is within this share of the derivative of position."""
DRIVES = ("effort", "current", "voltage")
"""What drives the motion, in the order in which it is preferred."""


@dataclass(frozen=True)
class ColumnGuess:
    """What a column is taken for."""

    column: str
    target: str | None
    """Name of the quantity, such as position_1; None: kept as an extra channel."""
    source: Source | None
    why: str


@np.errstate(over="ignore", invalid="ignore")  # of values that the import refuses
def guess(table: Table) -> list[ColumnGuess]:
    """Guess what each column of `table` holds. The list is in the order of the columns."""
    named = {name: name for name in table.columns if joint_quantity(name) or name in ("time", "cycle")}
    chosen = dict(named)
    if "time" not in chosen and (time := _time_column(table)):
        chosen["time"] = time
    taken = {joint_quantity(name)[0] for name in named if joint_quantity(name)}  # type: ignore[index]
    for quantity, columns in _quantities(table, set(chosen.values()), taken).items():
        chosen |= {f"{quantity}_{k}": column for k, column in enumerate(columns, start=1)}
    return _with_units(table, {column: target for target, column in chosen.items()})


def _time_column(table: Table) -> str | None:
    """The first column that increases most, and is called or measured as a time; or else the first that increases.

    A time that does not increase everywhere is one all the same: the import says in which line.
    """
    steps = {
        name: float((np.diff(values) > 0).mean())
        for name, values in table.columns.items()
        if len(values) > 1 and np.isfinite(values).all()
    }
    called = [name for name, share in steps.items() if kind(table, name) == "time" and share > _MOSTLY]
    increasing = [name for name, share in steps.items() if share == 1]
    return max(called, key=lambda name: steps[name], default=next(iter(increasing), None))


def _quantities(table: Table, used: set[str], taken: set[str]) -> dict[str, list[str]]:
    """Columns of each quantity in the order of the joints."""
    groups: dict[str, list[list[str]]] = {}
    for (kind, _), columns in _by_stem(table, used).items():
        groups.setdefault(kind, []).append(_numbered(columns))
    for kind, lists in groups.items():
        if all(len(columns) == 1 for columns in lists):  # joints with names of their own: a_pos, b_pos
            groups[kind] = [[columns[0] for columns in lists]]
    groups |= _whole(groups)
    position = [] if "position" in taken else _best(groups.pop("position", []), None)
    result = {"position": position} if position else {}
    dof = len(position) or len([name for name in table.columns if name.startswith("position_")])
    for kind in ("velocity", "command", "temperature"):
        if kind not in taken and (columns := _best(groups.get(kind, []), dof)):
            result[kind] = columns
    for kind in DRIVES:
        if not taken & set(DRIVES) and (columns := _best(groups.get(kind, []), dof)):
            return result | {kind: columns}
    return result


def _whole(groups: Mapping[str, list[list[str]]]) -> dict[str, list[list[str]]]:
    """Groups of one kind as one, where there are as many positions as torques, currents or voltages.

    Joints `elbow`, `wrist_1`, `wrist_2`, `wrist_3` are four, not the three that are numbered alike.
    """
    merged = {kind: [column for columns in lists for column in columns] for kind, lists in groups.items()}
    count = len(merged.get("position", ()))
    if not any(len(merged.get(drive, ())) == count for drive in DRIVES):
        return {}
    return {kind: [columns] for kind, columns in merged.items() if len(columns) == count}


def _by_stem(table: Table, used: set[str]) -> dict[tuple[str, tuple[str, ...]], list[str]]:
    """Columns by quantity and by the words of their names, without numbers."""
    stems: dict[tuple[str, tuple[str, ...]], list[str]] = {}
    for name, values in table.columns.items():
        quantity = kind(table, name)
        if quantity not in (None, "time") and name not in used and np.isfinite(values).any():
            stem = tuple(word for word in words_of(name) if not word.isdigit())
            stems.setdefault((str(quantity), stem), []).append(name)
    return stems


def _numbered(columns: list[str]) -> list[str]:
    """Sort columns of one stem by the number in their names that differs between them."""
    numbers = [[int(word) for word in words_of(name) if word.isdigit()] for name in columns]
    return [name for _, name in sorted(zip(numbers, columns, strict=True), key=lambda pair: pair[0])]


def _best(lists: list[list[str]], dof: int | None) -> list[str]:
    """The largest group, or the one of `dof` columns; of several, one that is called actual, or else the first."""
    fitting = [columns for columns in lists if dof is None or len(columns) == dof]
    return max(fitting, key=lambda c: (len(c), _has(_ACTUAL, words_of(c[0]))), default=[])


def words_of(name: str) -> list[str]:
    """Words and numbers of the name of a column, in small letters."""
    return [word.lower() for word in _TOKEN.findall(name)]


def _has(vocabulary: str, words: Sequence[str]) -> bool:
    return not set(vocabulary.split()).isdisjoint(words)


def kind(table: Table, name: str) -> str | None:
    """Quantity that the name or the unit of a column speaks for; None where neither does."""
    words = words_of(name)
    unit = _unit(table, name)
    if _has(_OTHER, words):
        return None
    quantity = quantity_of(unit) or next((_QUANTITY[word] for word in words if word in _QUANTITY), None)
    if unit.dimension in ("counts", "share") and quantity is None:
        quantity = "position" if unit.dimension == "counts" else "effort"
    if _has(_COMMAND, words):
        return "command" if quantity in ("position", None) else None
    return quantity


def _unit(table: Table, name: str) -> Unit:
    """Unit that the file states, or that ends the name as in q1_deg."""
    stated = parse(table.units.get(name, ""))
    ending = name.rpartition("_")[2]
    return stated or (parse(ending) if "_" in name and ending not in ("s", "m", "N", "K", "min") else None) or NO_UNIT


def _with_units(table: Table, targets: Mapping[str, str]) -> list[ColumnGuess]:
    """Guesses for all columns, where `targets` names the quantity of those that hold one."""
    guesses = {column: _with_unit(table, column, target) for column, target in targets.items()}
    for column, target in targets.items():
        if target.startswith("velocity_"):
            guesses[column] = _velocity(table, guesses, column, target)
    for column, values in table.columns.items():
        if column not in guesses:
            known = kind(table, column)
            why = f"{known}: another is taken, or joints lack it" if known else "name and unit say nothing known"
            guesses[column] = ColumnGuess(column, None, None, "no number in it" if np.isnan(values).all() else why)
    guesses |= {column: ColumnGuess(column, None, None, why) for column, why in table.invalid.items()}
    return [guesses[column] for column in (*table.columns, *table.invalid)]


def _with_unit(table: Table, column: str, target: str) -> ColumnGuess:
    """Guess of the unit of a column, from the file or from its values."""
    quantity = target.partition("_")[0]
    unit = _unit(table, column)
    if unit.dimension is not None:
        where = "file" if column in table.units else "name"
        return ColumnGuess(column, target, Source(column, unit), f"unit {unit.text} in the {where}")
    if target == column:
        return ColumnGuess(column, target, Source(column, unit), "name; SI unit")
    text, why = _likely_unit(quantity, table.columns[column])
    return ColumnGuess(column, target, Source(column, parse(text) or NO_UNIT), why)


def _likely_unit(quantity: str, values: Floats) -> tuple[str, str]:
    """Unit that the values speak for, and why."""
    known = values[np.isfinite(values)]
    extent = float(np.ptp(known)) if len(known) else 0.0
    if quantity == "time":
        return _time_unit(known)
    if quantity in ("position", "command"):
        if extent > _MIN_COUNTS and (known == np.rint(known)).all():
            return "counts", f"whole numbers over {extent:g}: counts of an encoder"
        if extent > _MAX_ANGLE:
            return "deg", f"range {extent:.4g} is too large for rad"
        return "rad", f"range {extent:.3g} fits rad"
    if quantity == "current" and np.abs(known).max(initial=0.0) > _MAX_CURRENT:
        return "mA", f"up to {np.abs(known).max():.4g} is too large for A"
    si = {"velocity": "rad/s", "effort": "Nm", "current": "A", "voltage": "V", "temperature": "degC"}
    return si.get(quantity, ""), "name; unit not stated"


def _time_unit(time: Floats) -> tuple[str, str]:
    step = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    for unit, seconds in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)):
        if step > 0 and _RATES[0] <= 1 / (step * seconds) <= _RATES[1]:
            return unit, f"increases; steps of {step:g} {unit} make {1 / (step * seconds):.4g} Hz"
    return "s", f"increases; steps of {step:g}"


def _velocity(table: Table, guesses: Mapping[str, ColumnGuess], column: str, target: str) -> ColumnGuess:
    """Guess the unit of a velocity without stated unit: the one in which it is the derivative of the position."""
    made, by_target = guesses[column], {each.target: each for each in guesses.values()}
    position, time = by_target.get(target.replace("velocity", "position")), by_target.get("time")
    stated = _unit(table, column).dimension is not None or target == column
    if stated or not position or not time or not position.source or not time.source:
        return made
    if position.source.unit.dimension not in ("angle", None):
        return made
    q = table.columns[position.column] * position.source.unit.factor
    t = table.columns[time.column] * time.source.unit.factor
    derivative, velocity = np.gradient(q, t), table.columns[column]
    known = np.isfinite(derivative) & np.isfinite(velocity)
    size = float(velocity[known] @ velocity[known])
    if size == 0:
        return made
    factor = float(velocity[known] @ derivative[known]) / size
    for text in ("rad/s", "deg/s", "rpm", "turns/s"):
        unit = parse(text)
        if unit and abs(factor / unit.factor - 1) < _MAX_SLOPE_ERROR:
            return ColumnGuess(
                column, target, Source(column, unit), f"in {text} it is the derivative of the position"
            )
    return made
