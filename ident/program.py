"""The commands of the program `ident`."""

import json
import subprocess
from typing import Any

from ident import commands
from recordings.command_line import CommandFolder
from recordings.errors import BadInput, ForeignFile

_LONGEST_GUESS = 60.0
"""Time to read a file of another program [s]."""

program = CommandFolder(
    commands,
    name="ident",
    help="Identify the dynamic model of a recorded mechanism and find where it fails.",
    epilog="Example: ident fit fig5a.mcap --validate fig5b.mcap",
    no_args_is_help=True,
)


def answer(**options: Any) -> None:
    """Run the program; for a file of another program, say the command that brings it in."""
    try:
        program(**options)
    except ForeignFile as error:
        raise BadInput(_how_to_import(error)) from None


def _how_to_import(foreign: ForeignFile) -> str:
    """What was found, and the `daq import` command that reads it, or why none does, as far as `daq` says so."""
    from ident.workbench.programs.running import daq_command

    try:
        arguments = [*daq_command(), "import", str(foreign.path), "--guess", "--json"]
        done = subprocess.run(
            arguments, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=_LONGEST_GUESS
        )
        if done.returncode:
            return f"{foreign.found}\n{done.stderr.strip().removeprefix('error: ')}"
        guess = json.loads(done.stdout)
    except (BadInput, OSError, ValueError, subprocess.TimeoutExpired):
        return foreign.for_command
    return foreign.for_command if guess["missing"] else f"{foreign.for_command}\nnext: {guess['command']}"
