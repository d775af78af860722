"""The commands of the program `daq`."""

from daq import commands
from recordings.command_line import CommandFolder

program = CommandFolder(
    commands,
    name="daq",
    help="Stream a motion to the amplifiers of a delta robot and record what happened.",
    epilog="Example: daq record --traj fig5a --out run.mcap",
    no_args_is_help=True,
)
