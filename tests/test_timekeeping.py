"""Detection of a machine that stalls; it excuses only failures of timing."""

import os
import signal
import subprocess
import time
from contextlib import suppress

import pytest

from tests import timekeeping
from tests.failures import Mistimed
from tests.timekeeping import Machine

GOOD, BAD = Machine(0.01, 0.0005, 1.1), Machine(1.7, 0.004, 3.9)


def test_timekeeping_is_measured_even_if_the_block_fails() -> None:
    with suppress(KeyError), timekeeping.watched() as machine:
        time.sleep(0.1)
        raise KeyError
    assert machine.slowness > 0
    assert 0 <= machine.usual <= machine.worst


def test_stall_is_detected(monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[int] = []
    original_popen = subprocess.Popen

    def start_and_store(*arguments: object, **options: object) -> object:
        process = original_popen(*arguments, **options)  # type: ignore[call-overload]
        started.append(process.pid)
        return process

    monkeypatch.setattr(subprocess, "Popen", start_and_store)
    with timekeeping.watched() as machine:
        time.sleep(0.1)
        os.kill(started[0], signal.SIGSTOP)
        time.sleep(0.3)
        os.kill(started[0], signal.SIGCONT)
        time.sleep(0.1)
    assert machine.worst > 0.2
    assert not machine.keeps_time


def test_only_a_condition_that_does_not_hold_fails_and_only_on_a_machine_that_keeps_time() -> None:
    GOOD.expect(True, "late")
    BAD.expect(True, "late")
    with pytest.raises(Mistimed, match="answers lost"):
        GOOD.expect(False, "answers lost")
    with pytest.raises(pytest.skip.Exception, match=r"up to 1700 ms late.*answers lost"):
        BAD.expect(False, "answers lost")
