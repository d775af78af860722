"""Lines of a TOML file with comments."""

import textwrap
from collections.abc import Iterator
from dataclasses import dataclass

STATED, NAMED, PHYSICS, ASSUMED, UNKNOWN = "stated: ", "named: ", "physics: ", "assumed: ", "unknown: "
"""Begin the comment of a value: where it comes from, and so how sure it is."""
LEGEND = {
    STATED: "an object of the drive holds it",
    NAMED: "the text of the dictionary says it",
    PHYSICS: "it cannot be otherwise",
    ASSUMED: "likely, but no drive states it: compare it with the machine",
    UNKNOWN: 'nothing says it: put it in place of "?", which no command accepts',
}
ASK = "?"
"""Value of a key that nothing says."""
_WIDTH, _COLUMN = 110, 36


@dataclass(frozen=True)
class Key:
    """One key; not `active`: commented out."""

    name: str
    value: str
    """As in the file."""
    comment: str = ""
    active: bool = True

    def lines(self) -> Iterator[str]:
        """The key with its comment behind it, or above it where it is long."""
        line = f"{'' if self.active else '# '}{self.name} = {self.value}"
        beside = f"{line.ljust(_COLUMN - 2)}  # {self.comment}" if self.comment else line
        if len(beside) > _WIDTH:
            yield from comment(self.comment)
            beside = line
        yield beside


def comment(text: str) -> Iterator[str]:
    """Comment lines; those of a list after its first are indented, so that none reads like a key."""
    indent = "#   " if text.startswith("- ") else "# "
    yield from textwrap.wrap(text, _WIDTH, initial_indent="# ", subsequent_indent=indent, break_on_hyphens=False)
