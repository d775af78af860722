import signal
import subprocess
import sys
import threading

import pytest

from ident.basics.threads import in_threads
from tests.patience import patient


def test_results_are_in_the_order_of_the_items() -> None:
    assert in_threads(lambda a, b: 10 * a + b, [1, 2, 3], (4, 5, 6)) == [14, 25, 36]
    assert in_threads(str, []) == []


def test_calls_within_calls_stay_in_their_thread() -> None:
    def threads_of_calls(_: int) -> set[int]:
        return {threading.get_ident(), *in_threads(lambda _: threading.get_ident(), range(20))}

    assert all(len(threads) == 1 for threads in in_threads(threads_of_calls, range(20)))


def test_an_error_reaches_the_caller() -> None:
    with pytest.raises(ZeroDivisionError):
        in_threads(lambda x: 1 / x, [1, 0, 2])


def test_a_forked_process_has_threads_of_its_own() -> None:
    program = (
        "import os; from ident.basics.threads import in_threads; in_threads(str, range(9)); "
        "child = os.fork(); result = in_threads(str, range(2)); child and os.waitpid(child, 0); print(result)"
    )
    command = [sys.executable, "-W", "ignore", "-c", program]
    result = subprocess.run(command, capture_output=True, text=True, timeout=patient(60), check=True)
    assert result.stdout.split("\n")[:2] == ["['0', '1']"] * 2


@pytest.mark.usefixtures("no_collection")
def test_an_interrupt_takes_back_what_has_not_begun() -> None:
    done: list[int] = []
    held, main = threading.Event(), threading.get_ident()

    def work(number: int) -> None:
        if number == 0:
            signal.pthread_kill(main, signal.SIGINT)
        held.wait(patient(60))
        held.set()  # an interrupt that does not arrive fails below, after the first minute
        done.append(number)

    with pytest.raises(KeyboardInterrupt):
        in_threads(work, range(1000))
    held.set()
    assert in_threads(abs, [-1, -2]) == [1, 2]
    assert len(done) < 1000
