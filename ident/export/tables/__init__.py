"""Formats of a table of torques. One format is one module of this folder, named as the user types it.

It holds `write(tables, path) -> int`, which writes the columns chunk by chunk and returns the number of rows.
"""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import cast

from ident.basics import plugins
from recordings.errors import BadInput
from recordings.recording import Floats

Write = Callable[[Iterable[dict[str, Floats]], Path], int]


def load(name: str) -> Write:
    """Load the format `name`.

    Raises:
        BadInput: there is no such format.
    """
    return cast(Write, plugins.load(__name__, name).write)


def format_of(path: Path) -> str:
    """Format of a file by its ending.

    Raises:
        BadInput: the ending is that of no format.
    """
    name = path.suffix.lower().removeprefix(".")
    if name not in plugins.names(__name__):
        known = ", ".join(f".{each}" for each in plugins.names(__name__))
        raise BadInput(f"{path}: an ending of {known} expected; rename the output, or give --to")
    return name
