"""The command that says a guess explicitly, and what it lacks."""

import shlex
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from recordings.files import free_name
from recordings.importing import formats
from recordings.importing.columns import DRIVES, ColumnGuess, guess
from recordings.importing.mapping import joint_quantity
from recordings.importing.table import JOINT_QUANTITIES, Table

PLACEHOLDER = "NUMBER"
"""Stands in a command for a number that the user has to know; `daq import` refuses it."""
UNIT = "UNIT"
"""Stands there for a unit."""
_PREVIEW_VALUES = 300
"""Number of values of a column in the JSON document."""


@dataclass(frozen=True)
class ImportProposal:
    """What the columns of a file are taken for."""

    table: Table
    guesses: list[ColumnGuess]
    arguments: list[str]
    """Those of `daq import` that say so."""
    missing: list[str]
    """Sentences on what they lack to work."""

    @property
    def command(self) -> str:
        """The command with these arguments."""
        return shlex.join(["daq", "import", *self.arguments])

    def as_json(self) -> dict[str, Any]:
        """The document of `daq import --guess --json`."""
        columns = [
            {
                "column": made.column,
                "name": made.target,
                "unit": made.source.unit.text or None if made.source else None,
                "why": made.why,
                "preview": self._preview(made.column),
            }
            for made in self.guesses
        ]
        return {
            "schema": 1,
            "columns": columns,
            "command": self.command,
            "assumed": [],  # nothing is assumed any more; the key stays
            "missing": self.missing,
        }

    def _preview(self, column: str) -> list[float | None]:
        """Some values of a column for a picture, evenly spread; None for a gap, and none of a column of text."""
        values = self.table.columns.get(column, np.empty(0))
        rows = np.linspace(0, len(values) - 1, min(len(values), _PREVIEW_VALUES)).astype(np.int64)
        return [float(value) if np.isfinite(value) else None for value in values[rows]]

    def lines(self) -> Iterator[str]:
        """Lines for the console."""
        width = max((len(made.column) for made in self.guesses), default=0)
        for made in self.guesses:
            unit = f" [{made.source.unit.text}]" if made.source and made.source.unit.text else ""
            yield f"{made.column:<{width}}  {(made.target or 'extra channel') + unit:<20}  {made.why}"
        yield from (*self.table.notes, *self.missing)
        yield f"{'complete it and run' if self.missing else 'next'}: {self.command}"


def propose(
    file: Path,
    given: Sequence[str] = (),
    out: Path | None = None,
    topic: str | None = None,
    names: tuple[str, ...] = (),
) -> ImportProposal:
    """Guess what the columns of `file` hold.

    Args:
        topic, names: as in `formats.read`.
        out: the recording to write; None: a new one in this folder.
        given: options of `daq import` that describe the machine, which the command repeats.

    Raises:
        BadInput: the file cannot be read.
    """
    table = formats.read(file, topic, names)
    guesses = guess(table)
    stem = file.resolve().name if file.is_dir() else file.stem
    out = out or free_name(Path(f"{stem}.mcap"))
    words = [str(file), "--out", str(out), *options(table, guesses, given), *given]
    return ImportProposal(table, guesses, words, missing(guesses, given))


def options(table: Table, guesses: Sequence[ColumnGuess], given: Collection[str] = ()) -> list[str]:
    """Options of `daq import` that say a guess explicitly, besides those that the user has `given`."""
    targets = [made for made in guesses if made.target and made.source]
    words = list(table.options)
    for made in sorted(targets, key=lambda made: _place(made.target or "")):
        unit = made.source.unit.text if made.source else ""
        if made.asks and not unit:
            words += ["--map", f"{made.target}={made.column}:{UNIT}"]
        elif made.column != made.target or unit not in ("", table.units.get(made.column)):
            words += ["--map", f"{made.target}={made.source}"]
    words += [] if {"--mechanism", "--rig"} & set(given) else _axes(targets)
    if _lacks_torque_per_ampere(guesses, given):
        words += ["--kt", PLACEHOLDER]
    return words


def _axes(guesses: Sequence[ColumnGuess]) -> list[str]:
    """Options that say what the joints are, where they are not those of a delta robot."""
    positions = _positions(guesses)
    slides = {made.target for made in guesses if made.source and made.source.unit.dimension == "length"}
    if not slides:
        return ["--mechanism", "axes"] if len(positions) in (1, 2) else []
    kinds = ["prismatic" if target in slides else "revolute" for target in positions]
    return ["--mechanism", "axes", "--joints", ",".join(kinds if len(set(kinds)) > 1 else kinds[:1])]


def _positions(guesses: Sequence[ColumnGuess]) -> list[str]:
    """Positions that are guessed, in the order of the joints."""
    targets = [made.target for made in guesses if made.target and made.target.startswith("position_")]
    return sorted(targets, key=_place)


def _place(target: str) -> tuple[int, int]:
    """Place of a quantity in the command: time, then positions, ..., each in the order of the joints."""
    quantity = joint_quantity(target)
    return (JOINT_QUANTITIES.index(quantity[0]) + 1, quantity[1]) if quantity else (0, 0)


def _lacks_torque_per_ampere(guesses: Sequence[ColumnGuess], given: Collection[str]) -> bool:
    """Whether currents are to become torque, and nothing says how."""
    targets = {made.target for made in guesses}
    return "current_1" in targets and not targets & {"effort_1", "voltage_1"} and not {"--kt", "--rig"} & set(given)


def missing(guesses: Sequence[ColumnGuess], given: Collection[str] = ()) -> list[str]:
    """Sentences on what the proposed command lacks to work."""
    targets = {made.target for made in guesses}
    sentences = []
    if "time" not in targets:
        sentences.append('no column increases as time does: --map "time=row:s*0.001" counts rows, here of 1 ms')
    if "position_1" not in targets:
        sentences.append('no column looks like a position: say which is, as in --map "position_1=COLUMN:deg"')
    if not any(f"{kind}_1" in targets for kind in DRIVES):
        sentences.append('no torque, current or voltage: say which is, as in --map "current_1=COLUMN:A"')
    if len(_positions(guesses)) > 3 and not {"--mechanism", "--rig"} & set(given) and not _axes(guesses):
        sentences.append(
            f"{len(_positions(guesses))} joints, where a delta robot has three: choose three with --names (of a bag; "
            "1,2,3 of position_1 ...) or with --map, or say what it is with --rig, or with --mechanism axes"
        )
    sentences += dict.fromkeys(made.asks for made in guesses if made.asks)
    unscaled = {made.source.unit.dimension for made in guesses if made.source and not made.source.unit.scaled}
    if unscaled & {"counts", "count rate"} and "--rig" not in given:
        sentences.append("counts need the counts per turn of the joint: write counts/8192, or give --rig with drives")
    if "share" in unscaled and "--rig" not in given:
        sentences.append("% needs the torque at 100 %: write %*20 for 20 Nm, or give --rig with drives")
    if _lacks_torque_per_ampere(guesses, given):
        sentences.append(
            f"--kt {PLACEHOLDER}: the file does not say the torque per ampere at the joint [N m/A]; put it in, or "
            "give --rig with torque.per_ampere"
        )
    return sentences
