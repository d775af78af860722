"""Hand what failed to one collector: with `--hand-to FOLDER`, a failed test is no error of this run of pytest.

`python -m tests.machinery.second_look FOLDER` decides at the end, after all runs.
"""

import json
import os
from collections import Counter
from collections.abc import Generator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import pytest

from tests.failures import Mistimed, Unsafe

FAILED, RUNS = "failed.jsonl", "runs.jsonl"
"""Files in the folder: a line for each failed test, and for each run of pytest."""
_KIND = "kind of failure"
"""Property of a report, which comes with it from the process of the test."""


@dataclass(frozen=True)
class Failure:
    """A test that failed."""

    test: str
    kind: Literal["test", "timing", "safety", "crash"]
    """Safety and crashes of a process of tests are not looked at again."""


@dataclass(frozen=True)
class Finished:
    """A run of pytest."""

    step: str
    """What called it."""
    passed: int
    failed: int
    skipped: int
    share: str
    """Share of the slow tests, with its digest."""


@pytest.hookimpl(wrapper=True)
def note_kind(call: pytest.CallInfo[None]) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Note on the report of a test whether safety or timing failed."""
    report = yield
    for failure, kind in ((Unsafe, "safety"), (Mistimed, "timing")):
        if call.excinfo is not None and call.excinfo.errisinstance(failure):
            report.user_properties.append((_KIND, kind))
    return report


class HandOver:
    """Plugin of the process that collects the reports."""

    def __init__(self, folder: Path, step: str, share: str) -> None:
        self._folder, self._step, self._share = folder, step, share
        self._failures: dict[str, Failure] = {}
        self._outcomes = Counter[str]()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Count a test once: by its call, or by what ended it before or after."""
        if report.when == "call" or report.outcome != "passed":
            self._outcomes[report.outcome] += 1
        if report.failed:
            crashed = report.when not in ("setup", "call", "teardown")
            kind: Any = "crash" if crashed else dict(report.user_properties).get(_KIND, "test")
            self._failures[report.nodeid] = Failure(report.nodeid, kind)

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Write what failed, and end well if nothing worse happened."""
        count = self._outcomes
        run = Finished(self._step, count["passed"], count["failed"], count["skipped"], self._share)
        _append(self._folder / RUNS, run)
        for failure in self._failures.values():
            _append(self._folder / FAILED, failure)
        if self._failures and session.exitstatus == pytest.ExitCode.TESTS_FAILED:
            session.exitstatus = pytest.ExitCode.OK


def _append(path: Path, line: Failure | Finished) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", encoding="utf-8") as file:
        file.write(f"{json.dumps(asdict(line))}\n")


def begin(config: pytest.Config) -> None:
    """Begin to hand over, in the process that collects, if `--hand-to` asks for it."""
    # A test that starts pytest itself hands nothing over.
    os.environ.pop("PYTEST_ADDOPTS", None)
    folder = config.getoption("--hand-to")
    if folder is not None and not hasattr(config, "workerinput"):
        share = f"{config.getoption('--share')} {config.getoption('--draw')}"
        config.pluginmanager.register(HandOver(Path(folder), os.environ.get("TEST_STEP", ""), share))
