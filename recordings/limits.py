"""What files of strangers may ask for: memory beside their size, depth, digits, keys, columns.

Every reader of both programs goes by these limits, so that a damaged file, or one made to do harm, ends in an error.
"""

import json
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from recordings.errors import BadInput, file_errors

_SMALL = 32_000_000
"""Memory that the smallest file may take [bytes]."""
_RATIO = 32
"""Memory that a byte of a file may take beside that [bytes]. Recordings reach 13 where nothing moves."""
NUMBER = 8
"""Size of a number in a table [bytes]."""
LARGEST_TEXT = 8_000_000
"""Largest JSON document [bytes]; a device such as /dev/zero has no end."""
_DEEPEST = 32
"""Levels of tables and arrays in each other."""
_LARGEST = 1e100
"""Largest number; its square must not overflow."""
_MOST_COLUMNS = 2_000
_LONGEST_LINE = 50_000
"""Of a table in text [characters]."""
_MOST_KEY_PARTS = 16
"""Names in one dotted key of TOML: the memory of its parser grows with their square."""
_KEY_PART = re.compile(r"""(?:"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+'|[\w+-]++)[ \t]*+(\.?)[ \t]*+|.""", re.DOTALL)


class Allowance:
    """The memory that may still be taken for the content of one file."""

    def __init__(self) -> None:
        self._left = _SMALL

    def take(self, size: int, packed: int = 0) -> None:
        """Take `size` bytes for what takes `packed` bytes of the file; what is refused takes nothing.

        Raises:
            ValueError: that is more than a file of this size may take.
        """
        left = self._left + _RATIO * packed - size
        if left < 0:
            raise ValueError(f"it unpacks to more than {_RATIO} times its size, as no measurement does")
        self._left = left


def bounded_text(path: Path, what: str, most: int = LARGEST_TEXT) -> str:
    """Read the text of a file of at most `most` bytes; `what` names its kind in errors.

    Raises:
        BadInput: it is missing, too large, no text in UTF-8, or cannot be read.
    """
    try:
        return bounded_content(path, what, most).decode("utf-8")
    except UnicodeDecodeError:
        raise BadInput(f"{what} {path} cannot be read: it is no text; check that it is one") from None


def bounded_content(path: Path, what: str, most: int) -> bytes:
    """Read a file of at most `most` bytes; `what` names its kind in errors.

    Raises:
        BadInput: it is missing, too large, or cannot be read.
    """
    with file_errors(f"{what} {path}"), path.open("rb") as stream:
        content = stream.read(most + 1)
    if len(content) > most:
        raise BadInput(f"{what} {path}: at most {most // 1000} kB expected, more found; check that it is one")
    return content


def json_object(path: Path, what: str) -> dict[str, Any]:
    """Read the JSON object in the file `path`, not validated; `what` names its kind in errors.

    Raises:
        BadInput: the file cannot be read, or holds no JSON object.
    """
    content = parsed(json.loads, bounded_text(path, what), f"{what} {path}", "JSON")
    if not isinstance(content, dict):
        raise BadInput(f"{what} {path}: a JSON object expected, something else found; check that it is one")
    return content


def parsed(parse: Callable[[str], Any], text: str, where: str, language: str, largest: float = _LARGEST) -> Any:
    """Parse the `text` of a file of this `language`; `where` names the file in errors.

    Raises:
        BadInput: it is not in this language, nested too deeply, or holds a number above `largest` in size.
    """
    try:
        content = parse(text)
    except RecursionError:
        raise BadInput(f"{where} is nested too deeply; check that it is one") from None
    except ValueError as error:  # also at integers of thousands of digits
        reason = str(error).partition(";")[0]  # behind it, how Python's own limit is raised
        raise BadInput(f"{where} is not valid {language}: {reason}; correct it, or check that it is one") from None
    _check(content, "", where, largest, _DEEPEST)
    return content


def _check(content: Any, key: str, where: str, largest: float, levels: int) -> None:
    """Raise BadInput at the first number too large to be meant; it would overflow in later computations."""
    if isinstance(content, dict | list):
        if not levels:
            raise BadInput(f"{where} is nested too deeply; check that it is one")
        for name, value in content.items() if isinstance(content, dict) else enumerate(content):
            _check(value, f"{key}.{name}" if key else str(name), where, largest, levels - 1)
    elif isinstance(content, int | float) and not abs(content) <= largest:
        shown = "a number of many digits" if isinstance(content, int) else f"{content:g}"
        raise BadInput(f"{where}: '{key}': a number of at most {largest:g} in size expected, found {shown}")


def check_keys(text: str, where: str) -> None:
    """Check the number of names in the dotted keys of TOML.

    Raises:
        BadInput: a key has too many.
    """
    run = 0
    for part in _KEY_PART.finditer(text):
        run = run + 1 if part[1] else 0
        if run > _MOST_KEY_PARTS:
            raise BadInput(f"{where}: keys of at most {_MOST_KEY_PARTS} names expected, more found; correct it")


def check_lines(lines: Iterable[str], where: str) -> None:
    """Check the length of `lines` of a table in text.

    Raises:
        BadInput: one is too long.
    """
    if any(len(line) > _LONGEST_LINE for line in lines):
        raise BadInput(f"{where}: lines of at most {_LONGEST_LINE} characters expected, a longer one found; check it")


def check_columns(count: int, where: str) -> None:
    """Check the number of columns of a table.

    Raises:
        BadInput: there are too many.
    """
    if count > _MOST_COLUMNS:
        raise BadInput(f"{where}: at most {_MOST_COLUMNS} columns expected, {count} found; check that it is a table")
