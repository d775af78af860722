"""`make bench`: every benchmark, one after the other; `python -m benchmarks NAME...` runs those.

Each is a process of its own, so that none stops or slows the next. One in which something did not answer in time,
while this machine did not keep time, was not measured: that is said in a line, and is no failure. Every other error
is one, and is shown whole. Exit code: 0 all is measured, or as much as this machine permits; 1 one failed.
"""

import subprocess
import sys
from collections.abc import Sequence

from benchmarks.alone import TOO_LATE
from tests import timekeeping

NAMES = ("reading", "cycle", "certificate", "coverage", "swarm", "commands", "workbench")
_STEP = 0.05
"""How often the machine is watched meanwhile [s]: a hundredth of a processor is not missed."""


def main(names: Sequence[str]) -> int:
    """Run them all; returns the exit code."""
    unknown = [name for name in names if name not in NAMES]
    if unknown:
        print(f"no benchmark {', '.join(unknown)}; there are: {', '.join(NAMES)}", file=sys.stderr)
        return 2
    return max([run(name, [sys.executable, "-m", "benchmarks.alone", name]) for name in names or NAMES])


def run(name: str, command: Sequence[str]) -> int:
    """Run one; returns 1 where it failed."""
    with timekeeping.watched(_STEP) as machine:
        done = subprocess.run(command, stderr=subprocess.PIPE, text=True)
    if done.returncode == 0:
        return 0
    if done.returncode == TOO_LATE and not machine.keeps_time:
        print(
            f"{name}: not measured, {_last_line(done.stderr)}. This machine does not keep time: {machine}", flush=True
        )
        return 0
    print(f"{name}: FAILED\n{done.stderr}", flush=True)
    return 1


def _last_line(text: str) -> str:
    return next(reversed(text.strip().splitlines()), "no reason given").rstrip(".")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
