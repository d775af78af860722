"""numba without warnings about its environment."""

import subprocess
import sys

import pytest

from tests.patience import patient

_WITHOUT_SEMAPHORES = """
import multiprocessing.context

refused = []

def refuse(self):
    refused.append(self)
    raise OSError(30, "Read-only file system")

multiprocessing.context.BaseContext.RLock = refuse
import numpy
from ident.estimation.l1_objective import L1Objective
assert L1Objective(numpy.ones((9, 2)), numpy.zeros(9))(numpy.ones((3, 2))).tolist() == [18.0] * 3
assert refused
"""


@pytest.mark.slow
def test_missing_shared_memory_raises_no_warning() -> None:
    process = subprocess.run(
        [sys.executable, "-W", "error", "-c", _WITHOUT_SEMAPHORES],
        capture_output=True,
        text=True,
        timeout=patient(600),
    )
    assert (process.returncode, process.stderr) == (0, "")
