"""`python -m benchmarks`: a failed benchmark does not stop the others, and a busy machine is not a failure."""

import importlib
import sys

import pytest

from benchmarks import __main__ as benchmarks
from tests.timekeeping import Machine

LATE = [sys.executable, "-c", "from recordings.errors import RunFailed; raise RunFailed('node 1 does not answer')"]
EXPIRED = [sys.executable, "-c", "import subprocess; raise subprocess.TimeoutExpired('daq sim', 1.0)"]
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
        (EXPIRED, False, 0, "cycle: not measured, Command 'daq sim' timed out after 1.0 seconds. This machine"),
        (LATE, True, 1, "RunFailed: node 1 does not answer"),
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
