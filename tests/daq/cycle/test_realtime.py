"""Real-time priority of the cycle. The permissions depend on the user of the tests, so both cases are accepted."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from daq.cycle.realtime import realtime_priority
from tests.patience import patient

pytestmark = pytest.mark.skipif(not hasattr(os, "sched_setscheduler"), reason="schedulers of Linux")

_PROGRAM = """
import os, resource, threading
from pathlib import Path
from daq.cycle.realtime import realtime_priority

{before}

def locked():
    return next(line.split()[1] for line in Path("/proc/self/status").read_text().splitlines() if "VmLck" in line)

lines, helper, over = [], [], threading.Event()
begun = threading.Thread(target=over.wait)
begun.start()
def helping():
    thread = begun.native_id
    return os.sched_getscheduler(thread) & ~os.SCHED_RESET_ON_FORK, os.sched_getparam(thread).sched_priority
with realtime_priority(lambda *line: lines.append(line)):
    others = []
    thread = threading.Thread(target=lambda: others.append(os.sched_getscheduler(0)))
    thread.start()
    thread.join()
    print(os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK, locked() != "0", others)
    helper.append(helping())
helper.append(helping())
over.set()
print(os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK, locked() != "0", lines)
print(*helper, sep="; ")
"""
_NOBODY = """
resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
resource.setrlimit(resource.RLIMIT_MEMLOCK, (0, 0))
if os.geteuid() == 0:
    os.setuid(65534)
"""


def _run(before: str) -> list[str]:
    # In a separate process, because locked memory and the scheduler affect the whole process.
    program = [sys.executable, "-c", _PROGRAM.format(before=before)]
    root = Path(__file__).parents[3]
    done = subprocess.run(program, cwd=root, capture_output=True, text=True, timeout=patient(300), check=True)
    return done.stdout.splitlines()


def test_without_permission_nothing_changes_and_the_report_says_so() -> None:
    assert _run(_NOBODY) == [
        "0 False [0]",
        "0 False [('info', 'host', 'no real-time priority (not permitted), no locked memory (not permitted)')]",
        "(0, 0); (0, 0)",
    ]


def test_report_matches_the_scheduler_and_the_block_restores_it() -> None:
    inside, after, helper = _run("")
    scheduler, locked, others = inside.split(" ", 2)
    assert others == "[0]", "threads of the block are ordinary ones"
    assert helper == ("(0, 0); (0, 0)" if scheduler == "0" else "(1, 1); (0, 0)"), "those begun before come with it"
    assert after.startswith("0 False ")
    assert ("no real-time priority" in after) == (scheduler == "0")
    assert ("no locked memory" in after) == (locked == "False")


def test_error_in_the_block_is_passed_on() -> None:
    with pytest.raises(KeyError), realtime_priority(lambda *line: None):
        raise KeyError
    assert os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK == os.SCHED_OTHER
