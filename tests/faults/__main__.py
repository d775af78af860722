"""`make faults`: run the whole campaign and print its tables; exit code 1 if an outcome is not as required.

`python -m tests.faults WORD...` runs only the faults whose names contain one of the words.
"""

import sys
from collections.abc import Callable

from tests.faults import campaign, canopen, feedforward, habits, processes, serial, table
from tests.faults.campaign import Outcome

words = sys.argv[1:]


def is_selected(name: str) -> bool:
    """Whether the fault `name` is selected on the command line."""
    return not words or any(word in name for word in words)


def run_and_print(run: Callable[[], Outcome]) -> Outcome:
    """Run one fault and print its outcome."""
    outcome = run()
    table.tick(outcome)
    return outcome


canopen_outcomes = [
    run_and_print(lambda fault=fault: campaign.run(fault)) for fault in canopen.FAULTS if is_selected(fault.name)
]
habit_outcomes = [
    run_and_print(lambda fault=fault: campaign.run(fault)) for fault in habits.FAULTS if is_selected(fault.name)
]
feedforward_outcomes = [
    run_and_print(lambda fault=fault: campaign.run(fault))
    for fault in (*feedforward.AGAIN, *feedforward.FAULTS)
    if is_selected(fault.name)
]
serial_outcomes = [
    run_and_print(lambda fault=fault: serial.run(fault))
    for fault in (*serial.FAULTS, *serial.WITH_FEEDFORWARD)
    if is_selected(fault.name)
]
process_outcomes = [
    run_and_print(lambda fault=fault: processes.run(fault)) for fault in processes.FAULTS if is_selected(fault.name)
]
if is_selected("disk full"):
    process_outcomes.append(run_and_print(processes.full_disk))
table.show("CANopen: bus, drives, machine, host (simulated time)", canopen_outcomes)
table.show("CANopen: habits and dictionaries of drives, warnings (simulated time)", habit_outcomes)
table.show("CANopen with a feed-forward (simulated time)", feedforward_outcomes)
table.show("serial lines, with and without a feed-forward (simulated time)", serial_outcomes)
table.show("programs: signals, death, disk (real time, two processes)", process_outcomes)
sys.exit(
    any(
        not outcome.passed
        for outcomes in (canopen_outcomes, habit_outcomes, feedforward_outcomes, serial_outcomes, process_outcomes)
        for outcome in outcomes
    )
)
