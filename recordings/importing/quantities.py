"""Quantities of a table in SI units: time, and those of the joints."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from recordings.errors import BadInput
from recordings.importing.mapping import Source, as_mapped, joint_quantity, or_guess
from recordings.importing.table import Table
from recordings.importing.units import RigHints, to_si
from recordings.plausible import LARGEST, first_implausible
from recordings.recording import Floats

_PARTIAL = ("temperature",)
"""Quantities that may be there for some joints only."""
_MAX_DOF = 64
"""Largest number of joints; a larger one is a mistake."""


@dataclass(frozen=True, eq=False)
class Quantities:
    """What a table holds, in SI units."""

    joints: dict[str, Floats]
    """(n, dof) by quantity."""
    cycle: str | None
    """Column with the number of the repetition."""
    extra: dict[str, Floats]
    """(n,) further columns, by name."""


def quantities(table: Table, sources: Mapping[str, Source], hints: RigHints) -> Quantities:
    """Convert the columns of `sources` to SI units; all other columns of numbers are extra.

    Raises:
        BadInput: positions are missing or invalid, joints are numbered with gaps, a unit does not fit, or no
            joint has such a value.
    """
    joints = _joints(table, sources, hints)
    cycle = sources["cycle"].column if "cycle" in sources else None
    return Quantities(joints, cycle, _extra(table, sources, hints))


def _joints(table: Table, sources: Mapping[str, Source], hints: RigHints) -> dict[str, Floats]:
    """Quantities (n, dof) of the joints in SI units, by name, without those that hold nothing but gaps."""
    numbers: dict[str, set[int]] = {}
    for name in sources:
        if (quantity := joint_quantity(name)) and quantity[0] not in _PARTIAL:
            numbers.setdefault(quantity[0], set()).add(quantity[1])
    dof = max(numbers.get("position", {0}))
    if not dof:
        raise BadInput(
            f"{table.path}: columns position_1, position_2, ... expected, {table.listed()} found; say which they "
            f"are, as in {as_mapped('position_1', 'COLUMN:deg')}{or_guess(table)}"
        )
    _check_numbers(table, numbers, dof)
    joints = {name: np.column_stack([_in_si(table, sources, name, k, hints) for k in range(dof)]) for name in numbers}
    joints = {name: values for name, values in joints.items() if name == "position" or np.isfinite(values).any()}
    if not {"voltage", "effort", "current"} & joints.keys():
        raise BadInput(
            f"{table.path}: columns voltage_1 ..., effort_1 ... or current_1 ... with numbers expected, none found; "
            f"say which they are, as in {as_mapped('current_1', 'COLUMN:A')}{or_guess(table)}"
        )
    return joints


def _check_numbers(table: Table, numbers: Mapping[str, set[int]], dof: int) -> None:
    for name, present in numbers.items():
        expected = set(range(1, dof + 1)) if dof <= _MAX_DOF else set()
        if wrong := sorted(present ^ expected):
            problem = "is missing" if wrong[0] in expected else f"has no position_{wrong[0]}"
            raise BadInput(
                f"{table.path}: one column {name}_i for each position_i expected, {name}_{wrong[0]} {problem}; map "
                f"it with {as_mapped(f'{name}_{wrong[0]}', 'COLUMN')}, or leave the others out"
            )


def _in_si(table: Table, sources: Mapping[str, Source], quantity: str, joint: int, hints: RigHints) -> Floats:
    """Column (n,) of a quantity of one joint, counted from 0, in SI units."""
    name = f"{quantity}_{joint + 1}"
    source = sources[name]
    where = f"{table.path}, column {source.column!r}"
    with np.errstate(over="ignore"):  # of values that are refused below
        values = to_si(table.column(source.column), source.unit, quantity, joint, hints, where)
    if wrong := first_implausible(values, quantity):
        raise BadInput(
            f"{table.location(wrong[0], source.column)}: {quantity} within ±{LARGEST[quantity]:g} (SI units) "
            f"expected, {values[wrong]:g} found; correct the value or leave its cell empty, or say its unit, as "
            f"in {as_mapped(name, f'{source.column}:UNIT')}"
        )
    return values


def _extra(table: Table, sources: Mapping[str, Source], hints: RigHints) -> dict[str, Floats]:
    """Columns (n,) that are no quantity of the motion, by name; current and temperature in SI units."""
    used = {column for source in sources.values() for column in source.columns} | set(table.unreadable)
    extra = {
        f"{name} (not used)" if name in sources else name: table.column(name)
        for name in table.columns
        if name not in used
    }
    for name in sources:
        if (quantity := joint_quantity(name)) and quantity[0] in ("current", "temperature"):
            extra[name] = _in_si(table, sources, quantity[0], quantity[1] - 1, hints)
    return extra
