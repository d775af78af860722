"""`make faults`: run the whole campaign and print its tables; exit code 1 if an outcome is not as required.

`python -m tests.faults WORD...` runs only the faults whose names contain one of the words. In real time, a busy
machine may end a run before its fault: then it is tried again.
"""

import sys

from tests.faults import campaign, canopen, feedforward, habits, power_up, processes, serial, table

TRIES = 3
words = sys.argv[1:]
CAMPAIGN = (
    ("CANopen: bus, drives, machine, host (simulated time)", campaign.run, canopen.FAULTS),
    ("CANopen: habits and dictionaries of drives, warnings (simulated time)", campaign.run, habits.FAULTS),
    ("CANopen with a feed-forward (simulated time)", campaign.run, (*feedforward.AGAIN, *feedforward.FAULTS)),
    (
        "serial lines, with and without a feed-forward (simulated time)",
        serial.run,
        (*serial.FAULTS, *serial.WITH_FEEDFORWARD),
    ),
    ("power-ups: turns that encoders lost, joints moved by hand (nothing moves)", power_up.run, power_up.FAULTS),
    ("programs: signals, death, disk (real time, two processes)", processes.run, processes.FAULTS),
)
tables = []
for title, run, faults in CAMPAIGN:
    outcomes = []
    for fault in faults:
        if not words or any(word in fault.name for word in words):
            for _ in range(TRIES):
                outcome = run(fault)  # type: ignore[operator]
                if outcome.begun:
                    break
            outcomes.append(outcome)
            table.tick(outcomes[-1])
    tables.append((title, outcomes))
for title, outcomes in tables:
    table.show(title, outcomes)
sys.exit(any(not outcome.passed for _, outcomes in tables for outcome in outcomes))
