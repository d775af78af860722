"""The two error classes of the commands; all packages raise these or subclasses of them."""


class BadInput(ValueError):
    """Invalid input from the user. Exit code 2.

    The message says what was expected, what was found and what to do, in one or two lines.
    """


class RunFailed(RuntimeError):
    """The run itself failed (drive fault, following error, bus loss). Exit code 1.

    When it is raised, the amplifiers are already disabled and the recording is closed.
    """
