"""The two ways in which a command can fail; every room raises these or subclasses of them."""


class BadInput(ValueError):
    """What the user gave cannot be used. Exit code 2.

    The message says what was expected, what was found and what to do, in one or two lines.
    """


class RunFailed(RuntimeError):
    """The run itself failed (drive fault, following error, bus loss). Exit code 1.

    Whoever raises it has already left the amplifiers disabled and the recording closed.
    """
