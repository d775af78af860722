"""`make faults`: the whole campaign and its tables; exit code 1 where something is not as required.

`python -m tests.faults WORD...` runs only the faults whose names hold one of the words.
"""

import sys
from collections.abc import Callable

from tests.faults import campaign, canopen, processes, serial, table
from tests.faults.campaign import Outcome

words = sys.argv[1:]


def chosen(name: str) -> bool:
    """Whether a fault was asked for."""
    return not words or any(word in name for word in words)


def tell(run: Callable[[], Outcome]) -> Outcome:
    """Run one fault and say so."""
    outcome = run()
    table.tick(outcome)
    return outcome


frames = [tell(lambda fault=fault: campaign.run(fault)) for fault in canopen.FAULTS if chosen(fault.name)]
lines = [tell(lambda fault=fault: serial.run(fault)) for fault in serial.FAULTS if chosen(fault.name)]
programs = [tell(lambda fault=fault: processes.run(fault)) for fault in processes.FAULTS if chosen(fault.name)]
if chosen("disk full"):
    programs.append(tell(processes.full_disk))
table.show("CANopen: bus, drives, machine, host (simulated time)", frames)
table.show("serial lines (simulated time)", lines)
table.show("programs: signals, death, disk (real time, two processes)", programs)
sys.exit(any(not outcome.passed for outcome in frames + lines + programs))
