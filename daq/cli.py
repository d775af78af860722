"""`daq`: stream a motion to the amplifiers and record what happened."""

import sys


def main() -> None:
    """Entry point of the program `daq`."""
    try:
        # Here, because Ctrl-C may come while they are imported, which takes a moment.
        from daq.program import program
        from recordings.command_line import run
    except KeyboardInterrupt:
        print("interrupted before anything moved", file=sys.stderr)
        sys.exit(1)
    run(program)
