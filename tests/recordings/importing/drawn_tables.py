"""Tables in text as people have them, drawn with a seed: what they hold, and whether their text decides it.

`python -m tests.recordings.importing.drawn_tables SEED` prints one.
"""

import sys
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta

import numpy as np

from recordings.recording import Floats

ROWS = 240
EPOCH = 1_767_600_000
"""2026-01-05 08:00:00 UTC [s since 1970]."""
_NAMES = {
    "numbers": ("q{0}", "qd{0}", "tau{0}"),
    "words": ("Position A{0}", "Speed A{0}", "Torque A{0}"),
    "indices": ("axis[{0}].ActPos", "axis[{0}].ActVelo", "axis[{0}].ActTorque"),
    "brackets": ("q[{0}]", "dq[{0}]", "tau_J[{0}]"),
    "German": ("Winkel_{0}", "Drehzahl_{0}", "Moment_{0}"),
    "words first": ("A{0} pos", "A{0} vel", "A{0} torque"),
}
_UNITS = {
    "position": {
        "rad": 1.0,
        "deg": np.pi / 180,
        "°": np.pi / 180,
        "° (Angle)": np.pi / 180,
        "mrad": 1e-3,
        "DEG": np.pi / 180,
    },
    "velocity": {"rad/s": 1.0, "deg/s": np.pi / 180, "°/s": np.pi / 180, "rpm": np.pi / 30, "1/min": np.pi / 30},
    "effort": {"Nm": 1.0, "mNm": 1e-3, "N m": 1.0, "N·m": 1.0, "Ncm": 1e-2, "0.1 Nm": 0.1},
}
_TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
FAULTS = {
    "text": "a number expected",
    "short row": "cells as in the header expected",
    "unknown unit": "is not known",
    "raw counts": "raw counts",
    "unsaid rate": "which may be",
    "name twice": "stands twice",
    "comma in a name": "names of",
    "rows exchanged": "a time after",
}
"""Faults that are asked for or refused, and what is said of them."""


@dataclass
class Drawn:
    """A table, and what it holds."""

    seed: int
    text: str = ""
    time: Floats = field(default_factory=lambda: np.empty(0))
    joints: dict[str, Floats] = field(default_factory=dict)
    """(n, dof) by quantity, in SI units."""
    fault: str = ""
    """What leaves it open; "" where the text decides."""
    place: str = ""
    """What an error names of it."""
    traits: set[str] = field(default_factory=set)


def draw(seed: int) -> Drawn:
    """The table of a `seed`."""
    return _Draw(seed).table()


class _Draw:
    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.drawn = Drawn(seed)
        self.traits = self.drawn.traits
        self.fault = [*FAULTS, "", ""][seed % 10]
        self.drawn.fault = self.fault
        self.delimiter = str(self.rng.choice([";", "\t", "|", ",", " "]))
        if self.fault == "comma in a name":
            self.delimiter = ","
        self.decimal = "," if self.delimiter != "," and self.rng.random() < 0.5 else "."
        self.grouped = self.delimiter not in (",", " ") and self.rng.random() < 0.4
        self.dof = int(self.rng.integers(1, 4))
        self.columns: list[tuple[str, str, list[str]]] = []
        """Name, unit, cells."""

    def chance(self, trait: str, share: float) -> bool:
        """Whether the table has a trait, which is noted."""
        has = bool(self.rng.random() < share)
        self.traits |= {trait} if has else set()
        return has

    def number(self, value: float, digits: int = 12) -> str:
        """A number as the file writes it."""
        text = f"{value:,.{digits}f}" if self.grouped else f"{value:.{digits}f}"
        return text.translate(str.maketrans(",.", ".,")) if self.decimal == "," else text

    def table(self) -> Drawn:
        """Draw everything, in an order that does not depend on what is drawn."""
        self._time()
        self._joints()
        if self.delimiter != "," and self.chance("counter", 0.4):
            self.columns.insert(
                0, (str(self.rng.choice(["seq", "index", "", "Nr"])), "", [str(k + 7) for k in range(ROWS)])
            )
        if self.chance("other order", 0.4):
            self.columns = (
                [self.columns[k] for k in self.rng.permutation(len(self.columns))] if not self.pair else self.columns
            )
        self.drawn.text = self._text()
        return self.drawn

    def _time(self) -> None:
        rate = float(self.rng.choice([100.0, 125.0, 250.0, 400.0]))
        if self.fault == "unsaid rate":
            rate = float(self.rng.choice([10.0, 20.0]))
        time = np.arange(ROWS) / rate
        if self.chance("gap in time", 0.2):
            time[ROWS // 2 :] += 17 / rate
        self.drawn.time = time
        self.pair = False
        kinds = {
            "wraps": 0.15,
            "set back": 0.15,
            "first zero": 0.18,
            "sec and nsec": 0.16,
            "date": 0.18,
            "date and time": 0.18,
        }
        kind = (
            "column"
            if self.fault in ("unsaid rate", "rows exchanged")
            else str(self.rng.choice(list(kinds), p=list(kinds.values())))
        )
        if kind in ("date", "date and time") and self.delimiter == " ":
            kind = "column"
        self.traits.add(kind)
        getattr(self, "_" + kind.replace(" ", "_"))(time)

    def _column(self, time: Floats) -> None:
        unit = "s" if self.fault == "unsaid rate" else str(self.rng.choice(list(_TIMES)))
        stated = self.fault != "unsaid rate" and self.rng.random() < 0.6
        if self.fault == "rows exchanged":
            time = time.copy()
            time[[40, 41]] = time[[41, 40]]
            self.drawn.place = "line "
        name = str(self.rng.choice(["t", "Zeit", "timestamp", "Time"]))
        self.columns.append((name, unit if stated else "", [self.number(value / _TIMES[unit]) for value in time]))

    def _wraps(self, time: Floats) -> None:
        ticks = np.rint(time * 1e6).astype(np.int64)
        counts = (ticks + 2**32 - ticks[ROWS // 3]) % 2**32
        self.columns.append(("t", "us", [str(count) for count in counts]))

    def _set_back(self, time: Floats) -> None:
        shown, step = time.copy(), time[1] - time[0]
        back = ROWS // 4
        shown[back:] -= shown[back] - shown[back - 1] + 12.4 * step
        self.columns.append(("t", "s", [self.number(value + 5) for value in shown]))

    def _first_zero(self, time: Floats) -> None:
        cells = [self.number(value + EPOCH, 6) for value in time]
        self.drawn.time = time[1:] - time[1]
        self.columns.append(("stamp", "s", [self.number(0, 6), *cells[1:]]))
        self.first = 1

    first = 0

    def _sec_and_nsec(self, time: Floats) -> None:
        ns = np.rint((time + 0.35) * 1e9).astype(np.int64)
        names = [("sec", "nanosec"), ("header.stamp.secs", "header.stamp.nsecs")][int(self.rng.integers(2))]
        self.columns += [
            (names[0], "", [str(EPOCH + k // 10**9) for k in ns]),
            (names[1], "", [str(k % 10**9) for k in ns]),
        ]
        self.pair = True

    def _date(self, time: Floats) -> None:
        dates = [datetime.fromtimestamp(EPOCH, UTC) + timedelta(microseconds=round(value * 1e6)) for value in time]
        self.columns.append(
            ("Timestamp", "", [date.isoformat(sep=" ", timespec="microseconds")[:26] for date in dates])
        )

    def _date_and_time(self, time: Floats) -> None:
        self._date(time)
        *before, (_, _, cells) = self.columns
        halves = [cell.split(" ") for cell in cells]
        self.columns = [*before, ("Date", "", [a for a, _ in halves]), ("Time", "", [b for _, b in halves])]
        self.pair = True

    def _joints(self) -> None:
        style = str(self.rng.choice(list(_NAMES)))
        phase = np.linspace(0, 9, ROWS)
        spoiled = int(self.rng.integers(self.dof))
        for quantity, pattern in zip(_UNITS, _NAMES[style], strict=True):
            if quantity == "velocity" and self.rng.random() < 0.5:
                continue
            unit, factor = list(_UNITS[quantity].items())[int(self.rng.integers(len(_UNITS[quantity])))]
            true = np.column_stack([(1 + k) * np.sin(phase * (1 + 0.3 * k) + k) * 3 + 0.1 for k in range(self.dof)])
            unsaid = self.fault == "raw counts" and quantity == "effort"
            for k in range(self.dof):
                values = np.rint(2000 * true[:, k]) if unsaid else true[:, k] / factor
                cells = [self.number(value, 0 if unsaid else 12) for value in values]
                if quantity == "effort" and self.chance("blanks", 0.2):
                    true[50:60, k] = np.nan
                    cells[50:60] = [("nan" if self.delimiter == " " else "")] * 10
                name, written = pattern.format(k + 1), "" if unsaid else unit
                if self.fault == "unknown unit" and quantity == "effort":
                    written, self.drawn.place = "furlong", "furlong"
                if self.fault == "text" and quantity == "effort" and k == spoiled:
                    cells[33], self.drawn.place = "---", f"column {self._plain(name)!r}"
                self.columns.append((name, written, cells))
            self.drawn.joints[quantity] = true[self.first :]
            if self.fault == "name twice" and quantity == "position":
                again = [(name, unit, cells) for name, unit, cells in self.columns if name == pattern.format(1)]
                self.columns += again

    def _text(self) -> str:
        names = [(name, unit) for name, unit, _ in self.columns]
        style = str(self.rng.choice(["brackets", "parentheses", "line"]))
        if self.delimiter == " " or self.fault == "unknown unit":
            style = "brackets"
        glue = "" if self.delimiter == " " else " "
        heads = [self._head(name, unit, style, glue) for name, unit in names]
        if self.fault == "comma in a name":
            heads[-1] = "Torque, Request"
            self.drawn.place = "line 1"
        lines = [self.delimiter.join(heads)]
        if style == "line" and any(unit for _, unit in names):
            lines.append(self.delimiter.join(unit or "-" for _, unit in names))
        rows = [list(row) for row in zip(*(cells for _, _, cells in self.columns), strict=True)]
        if self.fault == "short row":
            rows[77] = rows[77][:-1]
            self.drawn.place = f"line {78 + len(lines)}"
        if self.fault == "text":
            self.drawn.place = f"line {34 + len(lines)}, {self.drawn.place}"
        return "\n".join([*lines, *(self.delimiter.join(row) for row in rows)]) + "\n"

    def _plain(self, name: str) -> str:
        return name.replace(" ", "_") if self.delimiter == " " else name

    def _head(self, name: str, unit: str, style: str, glue: str) -> str:
        name = self._plain(name)
        unit = unit.replace(" ", "") if self.delimiter == " " else unit
        name = name or ("Unnamed:0" if self.delimiter == " " else name)
        if not unit or style == "line":
            return name
        return f"{name}{glue}[{unit}]" if style == "brackets" else f"{name}{glue}({unit})"


if __name__ == "__main__":
    table = draw(int(sys.argv[1]))
    print(table.text, f"fault: {table.fault or 'none'}; {', '.join(sorted(table.traits))}", sep="")
