"""`make faults`: the whole campaign and its table; exit code 1 where something is not as required.

`python -m tests.faults WORD...` runs only the faults whose names hold one of the words.
"""

import sys

from tests.faults import campaign, canopen, table

words = sys.argv[1:]
outcomes = []
for fault in canopen.FAULTS:
    if not words or any(word in fault.name for word in words):
        outcomes.append(campaign.run(fault))
        table.tick(outcomes[-1])
table.show("CANopen: bus, drives, machine, host", outcomes)
sys.exit(any(not outcome.passed for outcome in outcomes))
