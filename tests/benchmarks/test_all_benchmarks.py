"""`python -m benchmarks`: one that fails does not stop the others, and a busy machine is no failure."""

import importlib
import subprocess
import sys

import pytest

from benchmarks import __main__ as benchmarks
from benchmarks import alone
from recordings.errors import RunFailed
from tests.timekeeping import Machine

LATE = [sys.executable, "-c", "import sys; print('node 1 does not answer', file=sys.stderr); sys.exit(75)"]
BROKEN = [sys.executable, "-c", "raise KeyError('swarm')"]
GOOD = [sys.executable, "-c", ""]


def test_each_name_is_a_module_with_a_main() -> None:
    for name in benchmarks.NAMES:
        assert callable(importlib.import_module(f"benchmarks.{name}").main)


def test_a_name_that_is_none_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert benchmarks.main(["reading", "writing"]) == 2
    assert "no benchmark writing; there are: reading, cycle" in capsys.readouterr().err


def test_one_that_fails_is_shown_and_the_next_one_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    monkeypatch.setattr(benchmarks, "run", lambda name, command: asked.append(name) or name == "cycle")
    assert benchmarks.main(["cycle", "reading"]) == 1
    assert asked == ["cycle", "reading"]
    assert benchmarks.main(["reading"]) == 0


@pytest.mark.parametrize(
    ("command", "keeps_time", "code", "said"),
    [
        (GOOD, False, 0, ""),
        (LATE, False, 0, "cycle: not measured, node 1 does not answer. This machine does not keep time: sleeps end"),
        (LATE, True, 1, "cycle: FAILED\nnode 1 does not answer"),
        (BROKEN, False, 1, "KeyError: 'swarm'"),
    ],
)
def test_only_what_came_too_late_on_a_machine_that_does_not_keep_time_is_no_failure(
    command: list[str],
    keeps_time: bool,
    code: int,
    said: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(Machine, "keeps_time", keeps_time)
    assert benchmarks.run("cycle", command) == code
    assert said in capsys.readouterr().out


def _raise(error: Exception) -> None:
    raise error


@pytest.mark.parametrize("error", [RunFailed("silent"), TimeoutError("silent"), subprocess.TimeoutExpired("a", 1.0)])
def test_what_did_not_answer_in_time_is_known_by_its_kind(error: Exception) -> None:
    assert alone.run(lambda: _raise(error)) == alone.TOO_LATE


def test_other_errors_come_through() -> None:
    with pytest.raises(KeyError):
        alone.run(lambda: _raise(KeyError()))
    assert alone.run(lambda: None) == 0
