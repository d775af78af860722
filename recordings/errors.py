"""The two error classes of the commands; all packages raise these or subclasses of them."""

from collections.abc import Iterable


class BadInput(ValueError):
    """Invalid input from the user. Exit code 2.

    The message says what was expected, what was found and what to do, in one or two lines.
    """


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return a question about the `known` name that is most like a mistyped one, after a blank; or nothing."""
    from difflib import get_close_matches

    close = get_close_matches(name.lower(), known, n=1, cutoff=0.5)
    return f" did you mean {close[0]}?" if close else ""


class RunFailed(RuntimeError):
    """The run itself failed (drive fault, following error, bus loss). Exit code 1.

    When it is raised, the amplifiers are already disabled and the recording is closed.
    """
