"""Export of recordings to the formats of other programs.

Each format is one module of this folder, with the name that the user types and the interface `ExportFormat`.
"""

import importlib
import pkgutil
from pathlib import Path
from typing import BinaryIO, Protocol, cast

from recordings.errors import BadInput


class ExportFormat(Protocol):
    """Interface of each module of this folder."""

    def write(self, file: Path, stream: BinaryIO) -> str:
        """Write the recording `file` to `stream`; return the amount written, such as "200 samples".

        Raises:
            BadInput: the recording cannot be read, or holds no data for this format.
        """


def names() -> tuple[str, ...]:
    """List the available formats."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(__path__)))


def export(file: Path, name: str, out: Path) -> str:
    """Write the recording `file` to the new file `out` in the format `name`; return the amount written.

    Raises:
        BadInput: there is no such format, `out` exists, or the recording does not suit the format.
        OSError: `out` cannot be written; no partial file is left.
    """
    from recordings.files import new_file

    if name not in names():
        raise BadInput(f"one of {', '.join(names())} expected, format '{name}' found; choose one of these")
    form = cast(ExportFormat, importlib.import_module(f"{__name__}.{name}"))
    with new_file(out, "file") as stream:
        return form.write(file, stream)
