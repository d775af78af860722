"""`make fuzz`: feed 100,000 inputs of each kind, then diagnose 10,000 random recordings.

Prints the number of refused inputs, the growth of memory, and each diagnosis that fails. Options:

    --start N   diagnose only, from case N: resume
    --count M   number of diagnoses; with 1 that case is repeated
"""

import argparse
import resource
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from tests.fuzz import diagnoses, inputs

COUNT = 100_000
DIAGNOSES = 10_000
_REPORTED = 100
"""Number of diagnoses after which the progress is printed."""


def megabytes() -> float:
    """Peak memory of this process [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def campaign(name: str, run: Callable[[int], int]) -> None:
    """Run one kind of input after a warm-up and measure the growth of memory."""
    run(COUNT // 10)
    before, began = megabytes(), time.perf_counter()
    refused = run(COUNT)
    seconds = time.perf_counter() - began
    print(f"{name}: {COUNT:,} inputs in {seconds:.0f} s, {refused:,} noticed, memory +{megabytes() - before:.1f} MB")


def diagnose(first: int, end: int, folder: Path) -> int:
    """Run the cases `first` to `end` - 1, print those that fail, and return their number."""
    refused = failed = 0
    for case in range(first, end):
        outcome = diagnoses.run(case, folder)
        refused += bool(outcome.refusal)
        failed += bool(outcome.failure)
        if outcome.failure:
            print(f"case {case}: {outcome.failure}", flush=True)
        if (case + 1) % _REPORTED == 0 or case + 1 == end:
            print(f"diagnoses: cases {first} to {case}, {refused:,} refused, {failed:,} failed", flush=True)
    return failed


parser = argparse.ArgumentParser(prog="python -m tests.fuzz")
parser.add_argument("--start", type=int, help="diagnose only, from this case")
parser.add_argument("--count", type=int, help="number of diagnoses")
options = parser.parse_args()
with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    if options.start is None:
        sample = inputs.small_recording(folder / "sample.mcap")
        campaign("CAN frames to the driver", lambda count: inputs.frames_to_the_driver(count, 1))
        campaign("CAN frames to a simulated drive", lambda count: inputs.frames_to_a_drive(count, 2))
        campaign("serial replies", lambda count: inputs.serial_replies(count, 3))
        campaign("recordings", lambda count: inputs.files(count, 4, sample, folder))
    first = options.start or 0
    sys.exit(diagnose(first, first + options.count if options.count else DIAGNOSES, folder) > 0)
