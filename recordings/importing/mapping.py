"""Mappings from columns of a file to quantities: `--map "position_1=q1:deg"`, or a TOML file of the same."""

import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from recordings.config import toml_content
from recordings.errors import BadInput, did_you_mean, told
from recordings.importing.table import JOINT_QUANTITIES, ROW, Table
from recordings.importing.units import NO_UNIT, Unit, is_none, parse, split_header

TIMES = ("time", "cycle")
_TARGET = re.compile(rf"({'|'.join(JOINT_QUANTITIES)})_([1-9]\d*)|({'|'.join(TIMES)})")


@dataclass(frozen=True)
class Source:
    """Column of a file, and its unit; of a time in two columns, the one that counts parts of its steps as well."""

    column: str
    unit: Unit
    plus: "Source | None" = None

    def __str__(self) -> str:
        """As `--map` has it behind the equals sign."""
        own = f"{self.column}:{self.unit.text}" if self.unit.text else self.column
        return f"{own}+{self.plus}" if self.plus else own

    @property
    def parts(self) -> tuple[tuple[str, Unit], ...]:
        """Its columns and their units."""
        return ((self.column, self.unit), *(self.plus.parts if self.plus else ()))

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of its columns."""
        return tuple(name for name, _ in self.parts)


def as_mapped(target: str, source: str) -> str:
    """How the reader of an error maps a `source`, COLUMN:UNIT, to a quantity."""
    return told(f'--map "{target}={source}"', f'map={{"{target}": "{source}"}}')


def or_guess(table: Table) -> str:
    """The advice of a command to look at its guesses."""
    return told(f", or see daq import {shlex.quote(str(table.path))} --guess", "")


def joint_quantity(name: str) -> tuple[str, int] | None:
    """Quantity and number of the joint of a name such as "position_2"; None for other names."""
    match = _TARGET.fullmatch(name)
    return (match[1], int(match[2])) if match and match[1] else None


def sources(table: Table, entries: Sequence[str]) -> dict[str, Source]:
    """Find the column of each quantity: those that `entries` map, and others that are named like a quantity.

    Raises:
        BadInput: an entry is not NAME=COLUMN[:UNIT] or a TOML file of such, or its column or unit does not exist.
    """
    given: dict[str, Source] = {}
    for target, text in _pairs(entries):
        if not _TARGET.fullmatch(target):
            known = [*(f"{name}_1" for name in JOINT_QUANTITIES), *TIMES]
            raise BadInput(
                f"{_map()}: time, cycle, or {', '.join(JOINT_QUANTITIES)} with _1, _2 ... expected, {target!r} found;"
                f"{did_you_mean(target, known) or ' correct the name'}"
            )
        if target in given:
            raise BadInput(f"{_map()}: one column for {target} expected, two found; remove one")
        given[target] = _source(table, target, text)
    mapped = {*given, *(column for source in given.values() for column in source.columns)}
    named = {
        name: Source(name, _stated(table, name))
        for name in (*table.columns, *table.invalid)
        if _TARGET.fullmatch(name) and name not in mapped
    }
    for name in named:
        if again := next((other for other in table.columns if other.startswith(f"{name}#")), None):
            raise BadInput(
                f"{table.path}: every column needs a name of its own, {name!r} twice found; rename one, or choose "
                f"with {as_mapped(name, again)}"
            )
    return named | given


def _map() -> str:
    return told("--map", "map")


def _pairs(entries: Sequence[str]) -> list[tuple[str, str]]:
    pairs: list[tuple[str, str]] = []
    for entry in entries:
        target, equals, text = entry.partition("=")
        if equals:
            pairs.append((target.strip(), text.strip()))
        elif entry.endswith(".toml"):
            pairs += _file(Path(entry))
        else:
            raise BadInput(
                f'{_map()}: NAME=COLUMN:UNIT such as "position_1=q1:deg", or a TOML file, expected, {entry!r} found; '
                "correct it"
            )
    return pairs


def _file(path: Path) -> list[tuple[str, str]]:
    """Entries of a TOML file: `position_1 = "q1:deg"`."""
    content = toml_content(path, "mapping")
    for target, text in content.items():
        if not isinstance(text, str):
            raise BadInput(f'mapping {path}: {target} = "COLUMN:UNIT" expected, {text!r} found; put it in quotes')
    return list(content.items())


def _source(table: Table, target: str, text: str) -> Source:
    """Column and unit of `text`: COLUMN, or COLUMN:UNIT; names may hold colons."""
    if (column := _column(table, text)) is not None:
        return Source(column, _stated(table, column))
    if target == "time" and "+" in text and _column(table, text.rpartition(":")[0].strip()) is None:
        whole, part = (_source(table, target, half.strip()) for half in text.split("+", 1))
        return replace(whole, plus=part)
    name, colon, unit_text = (part.strip() for part in text.rpartition(":"))
    column = _column(table, name) if colon else None
    if column is None:
        column = name or text
        table.column(column)  # says that there is none
    unit = parse(unit_text)
    if unit is None:
        raise BadInput(
            f"{_map()} {target}: a unit such as deg, ms, A*0.12 or counts/8192 behind the colon expected, "
            f"{unit_text!r} found; correct it"
        )
    if unit.dimension is None:  # a factor alone scales the unit that the file states
        stated = _stated(table, column)
        unit = Unit(unit_text, stated.dimension, stated.factor * unit.factor, stated.offset * unit.factor, True)
    return Source(column, unit)


def _column(table: Table, text: str) -> str | None:
    """Name of the column that is called `text`, or so with its unit in brackets; None: there is none."""
    if text in table.columns or text in table.invalid or text == ROW:
        return text
    name, unit = split_header(text)
    return name if unit and table.units.get(name) == unit else None


def _stated(table: Table, name: str) -> Unit:
    """Unit that the file states.

    Raises:
        BadInput: it states one that is not known.
    """
    text = table.units.get(name, "")
    unit = parse(text)
    if unit is None and not is_none(text):
        raise BadInput(
            f"{table.path}, column {name!r}: a unit such as deg, Nm, ms or 0.1% expected, {text!r} found; say which "
            f"it is, as in {as_mapped('position_1', f'{name}:deg')}"
        )
    return unit or NO_UNIT
