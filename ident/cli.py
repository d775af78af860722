"""`ident`: identify the dynamic model of a recorded mechanism."""

import os

from ident import commands
from recordings.command_line import CommandFolder, run

program = CommandFolder(
    commands,
    name="ident",
    help="Identify the dynamic model of a recorded mechanism and find where it fails.",
    epilog="Example: ident fit fig5a.mcap --validate fig5b.mcap",
    no_args_is_help=True,
)


def main() -> None:
    """Entry point of the program `ident`."""
    # Matrices are long and narrow: BLAS threads would mostly wait for each other and keep the cores busy.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    run(program)
