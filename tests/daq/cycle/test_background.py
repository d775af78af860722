"""A thread runs as long as its block."""

import threading

import pytest

from daq.cycle.background import BackgroundThread


class Worker(BackgroundThread):
    def __init__(self) -> None:
        super().__init__("worker")
        self.running = threading.Event()
        self.ended_after_block = False

    def _run_thread(self) -> None:
        self.running.set()
        self.ended_after_block = self._finished.wait(10.0)


def names() -> list[str]:
    return [thread.name for thread in threading.enumerate()]


def test_thread_runs_in_the_block_and_has_ended_behind_it() -> None:
    with Worker() as worker:
        assert worker.running.wait(10.0)
        assert "worker" in names()
        assert not worker.ended_after_block
    assert worker.ended_after_block
    assert "worker" not in names()


def test_error_in_the_block_ends_the_thread_too_and_is_raised() -> None:
    worker = Worker()
    with pytest.raises(ValueError, match="block"), worker:
        raise ValueError("block")
    assert worker.ended_after_block
