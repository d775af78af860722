"""Arguments of the Python API that are one thing or a list; a TypeError names the one of a wrong type."""

from collections.abc import Sequence
from pathlib import Path
from types import UnionType
from typing import Any

from recordings.errors import BadInput


def names(given: object, name: str) -> tuple[str, ...]:
    """The names that the argument `name` gives: one, or a list of them.

    Raises:
        TypeError: it gives something else.
    """
    return _several(given, name, str, "a name or a list of names")


def paths(given: object, name: str) -> tuple[Path, ...]:
    """The paths that the argument `name` gives: one, or a list of them.

    Raises:
        TypeError: it gives something else.
    """
    return tuple(map(Path, _several(given, name, str | Path, "a path or a list of paths")))


def sources(given: object, name: str, least: int = 0) -> tuple[Any, ...]:
    """The recordings that the argument `name` gives: a path, a recording, or a list of either; None: none.

    Raises:
        TypeError: it gives something else.
        BadInput: they are fewer than `least`.
    """
    from recordings.recording import Recording

    words = "a path, a recording, or a list of them"
    several = _several(() if given is None else given, name, str | Path | Recording, words)
    if len(several) < least:
        raise BadInput("at least one recording expected, none found; check the pattern or the folder")
    return tuple(each if isinstance(each, Recording) else Path(each) for each in several)


def _several(given: object, name: str, kind: type | UnionType, words: str) -> tuple[Any, ...]:
    several = (given,) if isinstance(given, kind) else given
    if not isinstance(several, Sequence) or not all(isinstance(each, kind) for each in several):
        raise TypeError(f"{name}: {words} expected, {given!r} found")
    return tuple(several)
