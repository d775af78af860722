"""Recordings in the formats of other programs. One format is one file here, named as the user types it.

What a format's module holds is written down in `Format`.
"""

import importlib
import pkgutil
from pathlib import Path
from typing import BinaryIO, Protocol, cast

from recordings.errors import BadInput


class Format(Protocol):
    """What each module of this folder is."""

    def write(self, file: Path, stream: BinaryIO) -> str:
        """Write the recording `file` to `stream`; returns what was written, as "200 samples".

        Raises:
            BadInput: the recording cannot be read, or does not hold what this format is for.
        """
        ...


def names() -> tuple[str, ...]:
    """The formats there are."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(__path__)))


def export(file: Path, name: str, out: Path) -> str:
    """Write the recording `file` to the new file `out` in the format `name`; returns what was written.

    Raises:
        BadInput: there is no such format, `out` exists, or the format refuses the recording.
        OSError: `out` cannot be written; nothing of it is left.
    """
    from recordings.container_writer import create

    if name not in names():
        raise BadInput(f"one of {', '.join(names())} expected, format '{name}' found; choose one of these")
    form = cast(Format, importlib.import_module(f"{__name__}.{name}"))
    with create(out, "file") as stream:
        try:
            return form.write(file, stream)
        except BaseException:
            out.unlink()
            raise
