"""`daq`: stream a motion to the amplifiers and record what happened."""

import signal
import sys
from types import ModuleType


def main() -> None:
    """Entry point of the program `daq`."""
    _leave_out_log_files()
    try:
        # Here, because Ctrl-C may come while they are imported, which takes a moment.
        from daq.program import program
        from recordings.command_line import run
    except KeyboardInterrupt:
        print("interrupted before anything moved", file=sys.stderr)
        sys.exit(128 + signal.SIGINT)
    run(program)


def _leave_out_log_files() -> None:
    """Keep python-can from importing asammdf, and with it pandas, for log files that no command writes.

    They would take a third of the time in which the program starts.
    """
    module = ModuleType("can.io.mf4")
    vars(module).update(MF4Reader=None, MF4Writer=None)
    sys.modules["can.io.mf4"] = module
