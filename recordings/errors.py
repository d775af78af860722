"""The two error classes of the commands; all packages raise these or subclasses of them."""

import shlex
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import UnionType


class BadInput(ValueError):
    """Invalid input from the user. Exit code 2.

    The message says what was expected, what was found and what to do, in one or two lines.
    """


def expect(kind: type | UnionType, words: str, /, **arguments: object) -> None:
    """Check that all `arguments` of a function are of a `kind`, which `words` name.

    Raises:
        TypeError: one is not; it is named.
    """
    for name, value in arguments.items():
        if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):  # True is no number
            raise TypeError(f"{name}: {words} expected, {type(value).__name__} found")


def told(command: str, python: str) -> str:
    """`command` where a command of a program runs, else `python`: errors name arguments as their reader does."""
    click = sys.modules.get("click")
    return command if click and click.get_current_context(silent=True) else python


def printable(text: str) -> str:
    """Return `text` with a question mark for each control character, which names and values of others' files hold."""
    return "".join(character if character.isprintable() else "?" for character in text)


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return a question about the `known` name that is most like a mistyped one, after a blank; or nothing."""
    from difflib import get_close_matches

    close = get_close_matches(name.lower(), known, n=1, cutoff=0.5)
    return f" did you mean {close[0]}?" if close else ""


class RunFailed(RuntimeError):
    """The run itself failed (drive fault, following error, bus loss). Exit code 1.

    When it is raised, the amplifiers are already disabled and the recording is closed.
    """

    exit_code = 1


class StoppedByAlarm(RunFailed):
    """The run was stopped in order, because an alarm was raised. Exit code 3."""

    exit_code = 3


@contextmanager
def file_errors(name: str) -> Iterator[None]:
    """Say as BadInput why a file, which errors call `name`, does not exist or cannot be read in the block."""
    try:
        yield
    except FileNotFoundError:
        raise BadInput(f"{name} does not exist; check the path") from None
    except OSError as error:
        raise BadInput(f"{name} cannot be read: {error.strerror}; check the path") from None


class ForeignFile(BadInput):
    """A file that is no recording of this program, and may be brought in with `daq import`."""

    def __init__(self, message: str, path: Path) -> None:
        super().__init__(f'{message}; if another program wrote it: ident.read("{path}")')
        self.found, self.path = message, path

    @property
    def for_command(self) -> str:
        """The same for the reader of a command."""
        return f"{self.found}; if another program wrote it: daq import {shlex.quote(str(self.path))} --guess"
