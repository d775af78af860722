"""`ident`: identify the dynamic model of a recorded mechanism."""

from ident import commands
from recordings.command_line import CommandFolder, run

program = CommandFolder(
    commands,
    name="ident",
    help="Identify the dynamic model behind a recording, and see where it fails.",
    epilog="Example: ident fit fig5a.mcap --validate fig5b.mcap",
    no_args_is_help=True,
)


def main() -> None:
    """Entry point of the program `ident`."""
    run(program)
