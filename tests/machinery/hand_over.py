"""Hand what failed to one collector: with `--hand-to FOLDER`, a failed test is no error of this run of pytest.

`python -m tests.machinery.second_look FOLDER` decides at the end, after all runs.
"""

import json
import os
from collections import Counter
from collections.abc import Generator, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal, get_args

import pytest

from drivers.patience import factor
from recordings.errors import BadInput
from tests.failures import Mistimed, Unsafe
from tests.machinery import draw
from tests.timekeeping import NO_TIME

BEGUN, FAILED, RUNS = "begun.jsonl", "failed.jsonl", "runs.jsonl"
"""Files in the folder: a line for each run of pytest that began, for each failure, and for each run that ended."""
_KIND = "kind of failure"
"""Property of a report, which comes with it from the process of the test."""


Kind = Literal["timing", "test", "safety", "collection", "crash"]
"""Of a failure, the most serious last; only the first two are looked at again."""
KINDS: tuple[Kind, ...] = get_args(Kind)
SECOND_LOOK = KINDS[:2]


@dataclass(frozen=True)
class Failure:
    """A test that failed, a module that was not collected, or a process of tests that crashed."""

    test: str
    kind: Kind


@dataclass(frozen=True)
class Finished:
    """A run of pytest."""

    step: str
    """What called it."""
    passed: int
    failed: int
    skipped: int
    unjudged: int
    """Of those that were skipped, those for which the machine did not keep time."""
    share: str
    """Share of the slow tests, one in how many variations, and the digest, as words."""


@pytest.hookimpl(wrapper=True)
def note_kind(call: pytest.CallInfo[None]) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Note on the report of a test whether safety or timing failed."""
    report = yield
    if call.excinfo is not None:
        report.user_properties.append((_KIND, kind_of(call.excinfo.value)))
    return report


def kind_of(error: BaseException) -> Kind:
    """Kind of what ended a test: of safety also where another error came of it or beside it, as in a `finally`."""
    if any(isinstance(each, Unsafe) for each in _with_reasons(error)):
        return "safety"
    return "timing" if isinstance(error, Mistimed) else "test"


def _with_reasons(error: BaseException) -> Iterator[BaseException]:
    seen, left = set[int](), [error]
    while left:
        each = left.pop()
        if id(each) in seen:
            continue
        seen.add(id(each))
        yield each
        inner = each.exceptions if isinstance(each, BaseExceptionGroup) else ()
        left += [reason for reason in (each.__cause__, each.__context__, *inner) if reason is not None]


class HandOver:
    """Plugin of the process that collects the reports."""

    def __init__(self, folder: Path, step: str, share: str) -> None:
        self._folder, self._step, self._share = folder, step, share
        self._failures: list[Failure] = []
        self._outcomes = Counter[str]()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Count what a test came to: by its call, or by what ended it before or after."""
        if report.when == "call" or report.outcome != "passed":
            self._outcomes[report.outcome] += 1
        if report.skipped and NO_TIME in str(report.longrepr):
            self._outcomes["unjudged"] += 1
        if report.failed:
            crashed = report.when not in ("setup", "call", "teardown")
            kind: Any = "crash" if crashed else dict(report.user_properties).get(_KIND, "test")
            self._failures.append(Failure(report.nodeid, kind))

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """Note a module that is not collected: side by side, its tests would be missed by nobody."""
        if report.failed:
            self._failures.append(Failure(report.nodeid, "collection"))

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any, error: object) -> None:
        """Note a process of tests that crashed, also between two tests."""
        if error:
            self._failures.append(Failure(f"worker {node.gateway.id}", "crash"))

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Write what failed, and end well if nothing worse happened."""
        count = self._outcomes
        failed = len({failure.test for failure in self._failures})
        run = Finished(self._step, count["passed"], failed, count["skipped"], count["unjudged"], self._share)
        _append(self._folder / RUNS, run)
        for failure in self._failures:
            _append(self._folder / FAILED, failure)
        if self._failures and session.exitstatus == pytest.ExitCode.TESTS_FAILED:
            session.exitstatus = pytest.ExitCode.OK


def _append(path: Path, line: Failure | Finished | None) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", encoding="utf-8") as file:
        file.write(f"{json.dumps(line and asdict(line))}\n")


def begin(config: pytest.Config) -> None:
    """Begin to hand over, in the process that collects, if `--hand-to` asks for it.

    Raises:
        pytest.UsageError: what is to be drawn, or the patience, is not right.
    """
    draw.check(config)
    try:
        factor()
    except BadInput as error:
        raise pytest.UsageError(str(error)) from None
    # A test that starts pytest itself hands nothing over.
    os.environ.pop("PYTEST_ADDOPTS", None)
    folder = config.getoption("--hand-to")
    if folder and not hasattr(config, "workerinput"):
        _append(Path(folder) / BEGUN, None)
        share = " ".join(str(config.getoption(name)) for name in ("--share", "--one-in", "--draw"))
        config.pluginmanager.register(HandOver(Path(folder), os.environ.get("TEST_STEP", ""), share))
