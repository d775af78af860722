"""Formats that can be imported: each is one module of this folder, with the interface `ImportFormat`."""

import hashlib
import importlib
import pkgutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol, cast

from recordings.errors import BadInput, file_errors, printable
from recordings.files import sha256
from recordings.importing import long_tables
from recordings.importing.table import Table
from recordings.kinds import kind_of

_HEAD = 4096
"""Number of bytes by which a format is recognised."""
_LONGEST_REASON = 120
"""Number of characters of a library's error that are shown."""
_FALLBACK = "csv"
"""Format of text that no other format claims."""


class ImportFormat(Protocol):
    """Interface of each module of this folder; the one of text, which no other format claims, only reads."""

    def recognises(self, path: Path, head: bytes) -> bool:
        """Whether `path`, a file that begins with `head` or a folder, is in this format."""

    def read(self, path: Path) -> Table:
        """Read the file or folder `path`.

        Raises:
            BadInput: it cannot be read.
        """


def read(path: Path, topic: str | None = None, names: tuple[str, ...] = ()) -> Table:
    """Read `path` in the format that recognises its content; a long table becomes a wide one.

    Args:
        topic: of a ROS bag; None: the only one that fits.
        names: those of the joints that are read, in the order in which they are numbered; empty: all of them.

    Raises:
        BadInput: it does not exist, no format recognises it, it cannot be read, or does not hold what is wanted.
    """
    name = _recognised(path, _head(path))
    if name == "ros":
        from recordings.importing.formats import ros

        table = ros.read(path, topic, names)
    elif topic:
        raise BadInput(f"{path}: --topic chooses from a ROS bag, {name} found; leave it out")
    else:
        table = _load(name).read(path)
        if table.columns and table.count < 2:
            found = f"{table.count} found below the names {table.listed()}; export it again"
            raise BadInput(f"{path}: rows of numbers expected, {found}")
        table = long_tables.merged(long_tables.widened(table)).of_joints(names)
    return replace(table, digest=_digest(path))


def _recognised(path: Path, head: bytes) -> str:
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    for name in names:
        if name != _FALLBACK and _load(name).recognises(path, head):
            return name
    if known := kind_of(path, head):
        raise BadInput(f"{path}: measurements expected ({', '.join(names)}), {known[0]} found; {known[1]}")
    return _FALLBACK


def _load(name: str) -> ImportFormat:
    return cast(ImportFormat, importlib.import_module(f"{__name__}.{name}"))


@contextmanager
def reading(path: Path, kind: str, remedy: str) -> Iterator[None]:
    """Turn the errors of a library that reads `path`, at damaged files of every kind, into BadInput."""
    try:
        yield
    except BadInput:
        raise
    except Exception as error:
        raise BadInput(f"{path} cannot be read as {kind}: {reason(error)}; {remedy}") from None


def library(name: str, path: Path, kind: str, extra: str) -> Any:
    """Import the library that reads files of this `kind`.

    Raises:
        BadInput: it is not there; says which command installs it.
    """
    try:
        return importlib.import_module(name)
    except ImportError:
        package = name.partition(".")[0]
        raise BadInput(
            f"{path}: {package} reads {kind}, and is not there; pip install 'delta-workbench[{extra}]'"
        ) from None


def _digest(path: Path) -> str:
    """SHA-256 of a file, or of the files of a folder in the order of their names."""
    if not path.is_dir():
        return sha256(path)
    files = sorted(file for file in path.iterdir() if file.is_file())
    return hashlib.sha256("".join(map(sha256, files)).encode()).hexdigest()


def reason(error: BaseException) -> str:
    """The beginning of the first line of a library's error, which may quote the whole file."""
    lines = str(error).splitlines() or [type(error).__name__]
    text = printable(lines[0])
    return text if len(text) <= _LONGEST_REASON else f"{text[:_LONGEST_REASON]} ..."


def _head(path: Path) -> bytes:
    if path.is_dir():
        return b""
    if path.exists() and not path.is_file():
        raise BadInput(f"{path}: a file or a folder expected, a device found; check the path")
    with file_errors(str(path)), path.open("rb") as stream:
        return stream.read(_HEAD)
