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
from collections.abc import Iterable
from os import sched_getaffinity
from pathlib import Path

from tests.fuzz import diagnoses, files, inputs

FRAMES = 100_000
COUNT = 10_000
_REPORTED = 100
"""Number of files or diagnoses after which the progress is printed."""


def megabytes() -> float:
    """Peak memory of this process [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def frames() -> None:
    """Feed frames and replies to drives and drivers, after a warm-up, and measure the growth of memory."""
    for run in (inputs.frames_to_the_driver, inputs.frames_to_a_drive, inputs.serial_replies):
        run(FRAMES // 10, 1)
        before, began = megabytes(), time.perf_counter()
        noticed, seconds = run(FRAMES, 2), time.perf_counter() - began
        growth = megabytes() - before
        print(f"{run.__name__}: {FRAMES:,} in {seconds:.0f} s, {noticed:,} noticed, memory +{growth:.1f} MB")


def failed(outcomes: Iterable[files.Outcome]) -> int:
    """Print the `outcomes` that failed and a line for each kind, and return how many failed."""
    kinds: dict[str, list[files.Outcome]] = defaultdict(list)
    seen = Counter[str]()
    for number, outcome in enumerate(outcomes, start=1):
        kinds[outcome.kind].append(outcome)
        if outcome.failure:
            place = outcome.failure.strip().splitlines()[-1]
            seen[place] += 1
            shown = outcome.failure if seen[place] == 1 else place
            print(f"seed {outcome.seed}, {outcome.kind}: {shown}", flush=True)
        if number % _REPORTED == 0:
            print(f"{number:,} done, {seen.total()} failed, the last with seed {outcome.seed}", flush=True)
    for kind, of_kind in kinds.items():
        refusals, failures = sum(bool(each.refusal) for each in of_kind), sum(bool(each.failure) for each in of_kind)
        slowest, largest = max(each.seconds for each in of_kind), max(each.megabytes for each in of_kind)
        print(f"{kind}: {len(of_kind):,}, {refusals:,} refused, {failures} failed, {slowest:.1f} s, {largest:.0f} MB")
    return seen.total()


parser = argparse.ArgumentParser(prog="python -m tests.fuzz")
parser.add_argument("what", nargs="?", choices=["frames", "files", "diagnoses"])
parser.add_argument("--start", type=int, default=0, help="first seed of files and diagnoses")
parser.add_argument("--count", type=int, default=COUNT, help="number of files, and of diagnoses")
parser.add_argument("--kind", default="", help="only files whose name holds this")
options = parser.parse_args()
failures = 0
if options.what in (None, "frames"):
    frames()
if options.what in (None, "files"):
    failures += failed(files.attack(options.count, options.start, len(sched_getaffinity(0)), options.kind))
if options.what in (None, "diagnoses"):
    with tempfile.TemporaryDirectory() as name:
        seeds = range(options.start, options.start + options.count)
        failures += failed(diagnoses.run(seed, Path(name)) for seed in seeds)
sys.exit(failures > 0)
