"""Files of other programs: `daq import` guesses what their columns hold, and converts them."""

import shlex
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ident.workbench.programs.running import answer_of_daq
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
KEEP, EXCLUDE = "keep the time that is shown", "exclude the time that is shown"
NEGATE, SWAP, UNIT = "negate", "swap with joint", "read in the unit"
_OF_POSITION = {"position": "", "command": "", "velocity": "/s"}
"""Quantities that change with the position, and what follows its unit."""


@dataclass(frozen=True)
class FileColumn:
    """A column of the file and what it is taken for."""

    name: str
    quantity: str | None
    """Such as position_1; None: an extra channel."""
    unit: str
    why: str
    preview: tuple[float | None, ...]
    """Some values, evenly spread; None is a gap."""


@dataclass(frozen=True)
class FileGuess:
    """What `daq import --guess` says of a file."""

    file: str
    columns: tuple[FileColumn, ...]
    options: Mapping[str, str]
    """Other options of the command that it proposes."""
    remarks: tuple[str, ...]
    """What is missing."""

    @property
    def quantities(self) -> list[str]:
        """Return the quantities that a column may hold."""
        numbers = [(column.quantity or "").rpartition("_")[2] for column in self.columns]
        joints = max([_MIN_JOINTS, *(int(number) for number in numbers if number.isdigit())])
        return ["time", *(f"{name}_{joint}" for name in _JOINT_QUANTITIES for joint in range(1, joints + 1)), "cycle"]

    @property
    def machine(self) -> str:
        """Return the entry of `MACHINES` that the proposed command states."""
        if "--mechanism" not in self.options:
            return DELTA
        return PRISMATIC if self.options.get("--joints") == "prismatic" else REVOLUTE


def guess(root: Path, file: str) -> FileGuess:
    """Guess what the columns of `file` in the folder `root` hold.

    Raises:
        BadInput: the file cannot be read.
    """
    document = answer_of_daq(root, "import", file, "--guess")
    columns = tuple(
        FileColumn(item["column"], item["name"], item["unit"] or "", item["why"], tuple(item["preview"]))
        for item in document["columns"]
    )
    words = shlex.split(document["command"])[3:]
    pairs = zip(words, [*words[1:], ""], strict=True)
    options = {word: "" if value.startswith("--") else value for word, value in pairs if word.startswith("--")}
    return FileGuess(file, columns, options, tuple(document["missing"]))


def arguments(
    made: FileGuess,
    columns: Iterable[tuple[str, str, str]],
    machine: str,
    out: str,
    torque_per_ampere: float | None = None,
    joint_names: str = "",
) -> list[str]:
    """Return the arguments of the `daq import` that converts the file as chosen.

    columns: name, quantity or `EXTRA`, and unit. machine: entry of `MACHINES`, or a rig file. torque_per_ampere:
    [N m/A]. joint_names: those of a ROS bag, in the order of the joints.

    Raises:
        BadInput: two columns are chosen for one quantity, or the torque per ampere is not known.
    """
    words = ["import", made.file, "--out", out]
    sources: dict[str, str] = {}
    for column, quantity, unit in columns:
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
    words += MACHINES.get(machine, ("--rig", machine))
    if needs_torque_per_ampere(sources, machine):
        if not torque_per_ampere:
            raise BadInput(
                "the torque per ampere at the joint [N m/A] expected, none found; the file does not say it: put it "
                "in, or choose a rig file"
            )
        words += ["--kt", f"{torque_per_ampere!r}"]
    if topic := made.options.get("--topic"):
        words += ["--topic", topic]
    return [*words, "--names", joint_names] if joint_names else words


def needs_torque_per_ampere(quantities: Collection[str], machine: str) -> bool:
    """Whether currents drive the motion, and no rig file says what torque they make."""
    return "current_1" in quantities and not {"effort_1", "voltage_1"} & set(quantities) and machine in MACHINES


def convert(root: Path, words: Sequence[str]) -> tuple[str, ...]:
    """Run `daq` with the `arguments` in the folder `root`; return sentences on what it saw, warnings first.

    Raises:
        BadInput: the file cannot be converted so.
    """
    document = answer_of_daq(root, *words)
    seen = sorted(document["observations"], key=lambda item: item["level"] != "warning")
    head = f"{document['joints']} joints, {document['samples']} samples in {document['duration_s']:.3g} s"
    sentences = (f"{'Warning: ' if item['level'] == 'warning' else ''}{item['says']}" for item in seen)
    return (head, *dict.fromkeys(sentences), *document["notes"])


def preparation(
    columns: Collection[str], what: str, span: tuple[float, float], quantity: str, joints: Sequence[int], other: str
) -> list[str]:
    """Return the options of `daq import` that change a recording of our own.

    columns: those of the recording. what: one of the actions above. span: [s]. quantity: such as position, which
    takes its command and velocity along. joints: from 1. other: the unit, or the joint to swap with.
    """
    if what in (KEEP, EXCLUDE):
        return ["--trim" if what == KEEP else "--exclude", f"{span[0]:.3f}:{span[1]:.3f}"]
    pairs = [(joint, int(other)) for joint in joints] if what == SWAP else [(joint, joint) for joint in joints]
    pairs += [(second, first) for first, second in pairs if first != second]
    words = []
    for name, per_second in (_OF_POSITION if quantity == "position" else {quantity: ""}).items():
        unit = {NEGATE: ":*-1", UNIT: f":{other}{per_second}"}.get(what, "")
        entries = (f"{name}_{first}={name}_{second}{unit}" for first, second in pairs)
        words += [word for entry in entries if entry.partition("=")[0] in columns for word in ("--map", entry)]
    return words
