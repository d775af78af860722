"""Values of a rig file changed in place: its comments, its order and all other lines stay."""

import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from recordings.errors import BadInput
from recordings.files import replacement
from recordings.rig import load_rig


@dataclass(frozen=True)
class RigChange:
    """New value of one key."""

    table: str
    """Header of its table, such as "[torque]" or "[[drives]]"."""
    number: int
    """Which of the tables with this header, from 0."""
    key: str
    value: str
    """As TOML."""

    def __str__(self) -> str:
        which = f" of joint {self.number + 1}" if self.table.startswith("[[") else ""
        return f"{self.key} = {self.value}{which}"


def write_changes(path: Path, changes: Sequence[RigChange]) -> None:
    """Put the new values into the rig file `path`.

    Raises:
        BadInput: a value does not stand on a line of its own; the file is as it was.
    """
    lines = path.read_text(encoding="utf-8").splitlines()
    for change in changes:
        _apply(lines, change, path)
    try:
        with replacement(path) as draft:
            draft.write_text("\n".join(lines) + "\n", encoding="utf-8")
            load_rig(draft)
    except BadInput as error:
        raise BadInput(
            f"{path} cannot be changed by itself ({error}); write by hand: {list(map(str, changes))}"
        ) from None


def _apply(lines: list[str], change: RigChange, path: Path) -> None:
    heads = [k for k, line in enumerate(lines) if line.partition("#")[0].strip() == change.table]
    if change.number >= len(heads):
        if change.table.startswith("[["):
            raise BadInput(f"{path}: a table {change.table} for each joint expected; write {change.key} by hand")
        lines += ["", change.table]
        heads = [len(lines) - 1]
    head = heads[change.number]
    end = next((k for k in range(head + 1, len(lines)) if lines[k].lstrip().startswith("[")), len(lines))
    new = f"{change.key} = {change.value}"
    for k in range(head + 1, end):
        if re.match(rf"\s*{change.key}\s*=", lines[k]):
            lines[k] = new + _comment(lines[k], path)
            return
    lines.insert(head + 1, new)


def _comment(line: str, path: Path) -> str:
    """The comment behind a value, with the space before it."""
    for end in [*(match.start() for match in re.finditer(r"\s*#", line)), len(line)]:
        try:
            tomllib.loads(line[:end])
        except tomllib.TOMLDecodeError:
            continue
        return line[end:]
    raise BadInput(f"{path}: a value on a line of its own expected, found {line.strip()!r}; write it by hand")
