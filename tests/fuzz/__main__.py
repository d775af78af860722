"""`make fuzz`: feed frames to the drives, damaged files to the commands, random recordings to the diagnosis.

Prints what fails, with the seed that repeats it. Options:

    WHAT        frames, files or diagnoses; without it, all three
    --start N   first seed of the files and diagnoses
    --count M   number of files, or diagnoses; with 1 that seed is repeated
    --kind K    only files whose name holds K
"""

import argparse
import resource
import sys
import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Callable
from os import sched_getaffinity
from pathlib import Path

from tests.fuzz import diagnoses, files, inputs

FRAMES = 100_000
COUNT = 10_000
_REPORTED = 100
"""Number of diagnoses after which the progress is printed."""


def megabytes() -> float:
    """Peak memory of this process [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def campaign(name: str, run: Callable[[int], int]) -> None:
    """Run one kind of input after a warm-up and measure the growth of memory."""
    run(FRAMES // 10)
    before, began = megabytes(), time.perf_counter()
    refused = run(FRAMES)
    seconds = time.perf_counter() - began
    print(f"{name}: {FRAMES:,} inputs in {seconds:.0f} s, {refused:,} noticed, memory +{megabytes() - before:.1f} MB")


def frames() -> int:
    """Feed frames and replies to drives and drivers."""
    campaign("CAN frames to the driver", lambda count: inputs.frames_to_the_driver(count, 1))
    campaign("CAN frames to a simulated drive", lambda count: inputs.frames_to_a_drive(count, 2))
    campaign("serial replies", lambda count: inputs.serial_replies(count, 3))
    return 0


def read_files(start: int, count: int, kind: str) -> int:
    """Read damaged files, print those that fail and a line for each kind, and return the number of failures."""
    outcomes: dict[str, list[files.Outcome]] = defaultdict(list)
    seen = Counter[str]()
    for outcome in files.attack(count, start, processes=len(sched_getaffinity(0)), kind=kind):
        outcomes[outcome.kind].append(outcome)
        if outcome.failure:
            place = outcome.failure.strip().splitlines()[-1]
            seen[place] += 1
            shown = outcome.failure if seen[place] == 1 else place
            print(f"seed {outcome.seed}, {outcome.kind}: {shown}", flush=True)
    for name, results in outcomes.items():
        refused, failed = sum(bool(each.refusal) for each in results), sum(bool(each.failure) for each in results)
        slowest, largest = max(each.seconds for each in results), max(each.megabytes for each in results)
        print(
            f"{name}: {len(results):,} files, {refused:,} refused, {failed} failed, {slowest:.1f} s, {largest:.0f} MB"
        )
    print(f"files: seeds {start} to {start + count - 1}, {seen.total()} failed")
    return seen.total()


def diagnose(first: int, count: int, folder: Path) -> int:
    """Run `count` cases from `first` on, print those that fail, and return their number."""
    refused = failed = 0
    end = first + count
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
parser.add_argument("what", nargs="?", choices=["frames", "files", "diagnoses"])
parser.add_argument("--start", type=int, default=0, help="first seed of files and diagnoses")
parser.add_argument("--count", type=int, default=COUNT, help="number of files, and of diagnoses")
parser.add_argument("--kind", default="", help="only files whose name holds this")
options = parser.parse_args()
failures = 0
with tempfile.TemporaryDirectory() as name:
    if options.what in (None, "frames"):
        failures += frames()
    if options.what in (None, "files"):
        failures += read_files(options.start, options.count, options.kind)
    if options.what in (None, "diagnoses"):
        failures += diagnose(options.start, options.count, Path(name))
sys.exit(failures > 0)
