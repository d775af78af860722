"""`python -m benchmarks`: a failed benchmark does not stop the others, and a busy machine is not a failure."""

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


def test_unknown_name_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert benchmarks.main(["reading", "writing"]) == 2
    assert "no benchmark writing; there are: reading, cycle" in capsys.readouterr().err


def test_failure_sets_the_exit_code_and_the_next_benchmark_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    names: list[str] = []
    monkeypatch.setattr(benchmarks, "run", lambda name, command: names.append(name) or name == "cycle")
    assert benchmarks.main(["cycle", "reading"]) == 1
    assert names == ["cycle", "reading"]
    assert benchmarks.main(["reading"]) == 0


@pytest.mark.parametrize(
    ("command", "keeps_time", "code", "message"),
    [
        (GOOD, False, 0, ""),
        (LATE, False, 0, "cycle: not measured, node 1 does not answer. This machine does not keep time: sleeps end"),
        (LATE, True, 1, "cycle: FAILED\nnode 1 does not answer"),
        (BROKEN, False, 1, "KeyError: 'swarm'"),
    ],
)
def test_timeout_is_tolerated_only_on_a_machine_that_does_not_keep_time(
    command: list[str],
    keeps_time: bool,
    code: int,
    message: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(Machine, "keeps_time", keeps_time)
    assert benchmarks.run("cycle", command) == code
    assert message in capsys.readouterr().out


def _raise(error: Exception) -> None:
    raise error


@pytest.mark.parametrize("error", [RunFailed("silent"), TimeoutError("silent"), subprocess.TimeoutExpired("a", 1.0)])
def test_timeouts_are_recognized_by_the_type_of_the_error(error: Exception) -> None:
    assert alone.run(lambda: _raise(error)) == alone.TOO_LATE


def test_other_errors_are_raised() -> None:
    with pytest.raises(KeyError):
        alone.run(lambda: _raise(KeyError()))
    assert alone.run(lambda: None) == 0
