"""`make bench` runs all benchmarks in sequence; `python -m benchmarks NAME...` runs the named ones.

Each benchmark runs in its own process, so that a failure does not stop the next one. A timeout on a machine that
does not keep time is printed as "not measured" and does not count as a failure. Every other error is a failure and
is printed completely. Exit code: 0 no failure; 1 a benchmark failed; 2 unknown name.
"""

import re
import subprocess
import sys
from collections.abc import Sequence

from tests import timekeeping

NAMES = (
    "reading",
    "cycle",
    "intervals",
    "torque",
)
_STEP = 0.05
"""Interval at which timekeeping is measured meanwhile [s]; this costs about 1 % of a processor."""
_ERROR = re.compile(r"^([\w.]+): (.*)", re.MULTILINE)
"""Type and message of an error, in the last lines of a traceback."""
_TIMEOUT = re.compile(r"Timeout|(RunFailed|SdoCommunicationError)$")
"""Types of errors that a busy machine can cause: a run that ended early, or a timeout of any library."""


def main(names: Sequence[str]) -> int:
    """Run the benchmarks `names`, or all of them; return the exit code."""
    unknown = [name for name in names if name not in NAMES]
    if unknown:
        print(f"no benchmark {', '.join(unknown)}; there are: {', '.join(NAMES)}", file=sys.stderr)
        return 2
    return max([run(name, [sys.executable, "-m", f"benchmarks.{name}"]) for name in names or NAMES])


def run(name: str, command: Sequence[str]) -> int:
    """Run one benchmark by its `command`; return 1 if it failed."""
    with timekeeping.watched(_STEP) as machine:
        done = subprocess.run(command, stderr=subprocess.PIPE, text=True)
    if done.returncode == 0:
        return 0
    errors = _ERROR.findall(done.stderr)
    if errors and _TIMEOUT.search(errors[-1][0]) and not machine.keeps_time:
        reason = errors[-1][1].rstrip(".")
        print(f"{name}: not measured, {reason}. This machine does not keep time: {machine}", flush=True)
        return 0
    print(f"{name}: FAILED\n{done.stderr}", flush=True)
    return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
