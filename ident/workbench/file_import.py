"""Files of other programs: `daq import`, run as a process of its own, guesses what the columns hold and converts.

Nothing of `daq` is imported.
"""

import json
import shlex
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from subprocess import TimeoutExpired
from typing import Any

from ident.workbench.folder import SUFFIX
from ident.workbench.recording_process import messages, run_daq
from recordings.errors import BadInput

DELTA, REVOLUTE, PRISMATIC = "delta robot", "axes, revolute", "axes, prismatic"
MACHINES: dict[str, tuple[str, ...]] = {
    DELTA: (),
    REVOLUTE: ("--mechanism", "axes"),
    PRISMATIC: ("--mechanism", "axes", "--joints", "prismatic"),
}
"""What was measured, as options; or else it is a rig file."""
EXTRA = "extra channel"
"""A column that is kept and takes no part in a fit."""
_JOINT_QUANTITIES = ("position", "velocity", "command", "voltage", "effort", "current", "temperature")
_MIN_JOINTS = 3


@dataclass(frozen=True)
class Column:
    """A column of the file and what it is taken for."""

    name: str
    quantity: str | None
    """Such as position_1; None: an extra channel."""
    unit: str
    why: str
    preview: tuple[float | None, ...]
    """Some values, evenly spread; None is a gap."""


@dataclass(frozen=True)
class Guess:
    """What `daq import --guess` says of a file."""

    file: str
    columns: tuple[Column, ...]
    command_options: dict[str, str]
    """Other options of the command that it proposes."""
    remarks: tuple[str, ...]
    """What is missing."""

    @property
    def quantities(self) -> list[str]:
        """Return the quantities that a column may hold."""
        joints = max([_MIN_JOINTS, *(_joint(column.quantity) for column in self.columns)])
        return ["time", *(f"{name}_{joint}" for name in _JOINT_QUANTITIES for joint in range(1, joints + 1)), "cycle"]

    @property
    def machine(self) -> str:
        """Return the entry of `MACHINES` that the proposed command states."""
        if "--mechanism" not in self.command_options:
            return DELTA
        return PRISMATIC if self.command_options.get("--joints") == "prismatic" else REVOLUTE


@dataclass(frozen=True)
class Choice:
    """What the user chose for the columns of a file."""

    columns: tuple[tuple[str, str, str], ...]
    """Column, quantity or `EXTRA`, and unit."""
    machine: str
    """Entry of `MACHINES`, or a rig file."""
    torque_per_ampere: float | None = None
    """[N m/A]."""
    joint_names: str = ""
    """Of a ROS bag, in the order of the joints."""


def guess(root: Path, file: str) -> Guess:
    """Guess what the columns of `file` in the folder `root` hold.

    Raises:
        BadInput: the file cannot be read.
    """
    document = _run(root, "import", file, "--guess", "--json")
    columns = tuple(
        Column(item["column"], item["name"], item["unit"] or "", item["why"], tuple(item["preview"]))
        for item in document["columns"]
    )
    parsed = _parse_command(shlex.split(document["command"])[3:])
    return Guess(file, columns, parsed, tuple(document["missing"]))


def arguments(made: Guess, choice: Choice, out: str) -> list[str]:
    """Return the arguments of the `daq import` that converts the file as chosen.

    Raises:
        BadInput: two columns are chosen for one quantity, or the torque per ampere is not known.
    """
    words = ["import", made.file, "--out", out]
    sources: dict[str, str] = {}
    for column, quantity, unit in choice.columns:
        if quantity == EXTRA:
            continue
        if quantity in sources:
            raise BadInput(
                f"one column for {quantity} expected, {sources[quantity]} and {column} found; choose another "
                "quantity for one of them"
            )
        sources[quantity] = column
        if column != quantity or unit:
            words += ["--map", f"{quantity}={column}{f':{unit}' if unit else ''}"]
    words += MACHINES.get(choice.machine, ("--rig", choice.machine))
    if needs_torque_per_ampere(sources, choice.machine):
        if not choice.torque_per_ampere:
            raise BadInput(
                "the torque per ampere at the joint [N m/A] expected, none found; the file does not say it: put it "
                "in, or choose a rig file"
            )
        words += ["--kt", f"{choice.torque_per_ampere!r}"]
    if topic := made.command_options.get("--topic"):
        words += ["--topic", topic]
    if choice.joint_names:
        words += ["--names", choice.joint_names]
    return words


def needs_torque_per_ampere(quantities: Collection[str], machine: str) -> bool:
    """Whether currents drive the motion, and no rig file says what torque they make."""
    return "current_1" in quantities and not {"effort_1", "voltage_1"} & set(quantities) and machine in MACHINES


def convert(root: Path, words: Sequence[str]) -> tuple[str, ...]:
    """Run `daq` with the `arguments` in the folder `root`; return sentences on what it saw, warnings first.

    Raises:
        BadInput: the file cannot be converted so.
    """
    document = _run(root, *words, "--json")
    seen = sorted(document["observations"], key=lambda item: item["level"] != "warning")
    head = f"{document['joints']} joints, {document['samples']} samples in {document['duration_s']:.3g} s"
    sentences = (f"{'Warning: ' if item['level'] == 'warning' else ''}{item['says']}" for item in seen)
    return (head, *dict.fromkeys(sentences), *document["notes"])


def free_name(root: Path, file: str) -> str:
    """Return a name for the recording that is made of `file`."""
    stem = Path(file).stem
    names = (f"{stem}{ending}{SUFFIX}" for ending in ("", "-imported", *(f"-imported-{n}" for n in range(2, 1000))))
    return next(name for name in names if not (root / name).exists())


def sparkline(values: Sequence[float | None], width: int = 150, height: int = 32) -> str:
    """Return an SVG picture of `values` over their index, with gaps."""
    numbers = [value for value in values if value is not None]
    if not numbers:
        return ""
    low, span = min(numbers), (max(numbers) - min(numbers)) or 1.0
    step = width / max(len(values) - 1, 1)
    path, pen = [], "M"
    for index, value in enumerate(values):
        if value is not None:
            path.append(f"{pen}{index * step:.1f} {height - 2 - (value - low) / span * (height - 4):.1f}")
        pen = "M" if value is None else "L"
    return (
        f'<svg viewBox="0 0 {width} {height}" width="{width}" height="{height}" aria-hidden="true">'
        f'<path d="{"".join(path)}" fill="none" stroke="currentColor" stroke-width="1.2"/></svg>'
    )


def _joint(quantity: str | None) -> int:
    number = (quantity or "").rpartition("_")[2]
    return int(number) if number.isdigit() else 0


def _parse_command(words: Sequence[str]) -> dict[str, str]:
    """Return the options in `words`, except for the columns and the file that is written."""
    pairs = zip(words, [*words[1:], ""], strict=True)
    options = {word: "" if value.startswith("--") else value for word, value in pairs if word.startswith("--")}
    return {name: value for name, value in options.items() if name not in ("--map", "--out")}


def _run(root: Path, *words: str) -> Mapping[str, Any]:
    try:
        process = run_daq(root, *words)
    except (OSError, TimeoutExpired) as error:
        raise BadInput(
            f"{words[1]}: an answer of `daq import` expected, {error} found; import it in a terminal"
        ) from None
    if process.returncode:
        raise BadInput(" ".join(messages(process.stderr.splitlines())).removeprefix("error: "))
    document: Mapping[str, Any] = json.loads(process.stdout)
    return document
