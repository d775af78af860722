"""The two error classes of the commands; all packages raise these or subclasses of them."""

import shlex
from pathlib import Path


class BadInput(ValueError):
    """Invalid input from the user. Exit code 2.

    The message says what was expected, what was found and what to do, in one or two lines.
    """


class RunFailed(RuntimeError):
    """The run itself failed (drive fault, following error, bus loss). Exit code 1.

    When it is raised, the amplifiers are already disabled and the recording is closed.
    """


class ForeignFile(BadInput):
    """A file that is no recording of this program, and may be brought in with `daq import`."""

    def __init__(self, message: str, path: Path) -> None:
        super().__init__(f"{message}; if another program wrote it: daq import {shlex.quote(str(path))} --guess")
        self.path = path
