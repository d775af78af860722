"""Fixtures of all tests: run the programs as a user does."""

import faulthandler
import gc
import importlib
import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from _pytest.faulthandler import fault_handler_stderr_fd_key  # output of tests is captured already
from hypothesis import HealthCheck, settings

from tests.machinery import draw, hand_over
from tests.patience import patient

# Each worker of pytest-xdist has its own persistent Numba cache: if two processes compile a function for different
# arguments at the same time, one overwrites the code of the other. It begins with what the programs of this checkout
# have compiled, because all functions take half a minute.
if (_worker := os.environ.get("PYTEST_XDIST_WORKER")) is not None:
    _ROOT = Path(__file__).parents[1]
    _cache = _ROOT / ".pytest_cache" / "numba" / _worker
    os.environ["NUMBA_CACHE_DIR"] = str(_cache)
    if not _cache.exists():
        from numba.core.caching import _CacheLocator

        for _file in _ROOT.glob("ident/**/__pycache__/*.nb[ci]"):
            _place: Any = _CacheLocator  # Numba has no types
            _folder = _cache / _place.get_suitable_cache_subpath(str(_file.parents[1] / "module.py"))
            _folder.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(_file, _folder / _file.name)

# What the user of this machine has adopted, and where drives stood, is no part of any test.
os.environ["DELTA_WORKBENCH_EFFECTS"] = ""
os.environ["DELTA_WORKBENCH_POSES"] = ""

# On CI the examples are always the same; elsewhere they are drawn again each time.
# There is no time limit, because the machine may be busy.
_ANY_SPEED: dict[str, Any] = {"deadline": None, "suppress_health_check": [HealthCheck.too_slow]}
settings.register_profile("desk", **_ANY_SPEED)
settings.register_profile("ci", derandomize=True, **_ANY_SPEED)
settings.load_profile("ci" if os.environ.get("CI") == "true" else "desk")


_DEADLINE, _SLOW_DEADLINE = 300.0, 900.0
"""Time that a test may take [s] if it has none of its own; it is ended and named then."""

pytest_runtest_makereport = hand_over.note_kind


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add what `make` and `.ci/run` ask for."""
    parser.addoption("--share", default="1/1", help="run such a share of the modules, and what is essential")
    parser.addoption("--one-in", type=int, default=1, help="run one in so many variations of each test")
    parser.addoption("--draw", default="any", help="digest that draws them")
    parser.addoption("--hand-to", metavar="FOLDER", help="hand failures to tests.machinery.second_look, and succeed")


def pytest_configure(config: pytest.Config) -> None:
    """Hand failures over, where it is asked for."""
    hand_over.begin(config)


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Leave out modules that are not drawn."""
    return draw.is_left_out(config, collection_path) or None


@pytest.hookimpl(wrapper=True)
def pytest_collection(session: pytest.Session) -> Generator[None, object, object]:
    """End a process whose tests are not collected in time, as where a module waits while it is imported."""
    faulthandler.dump_traceback_later(
        patient(_DEADLINE), exit=True, file=session.config.stash[fault_handler_stderr_fd_key]
    )
    try:
        return (yield)
    finally:
        faulthandler.cancel_dump_traceback_later()


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep what is drawn or essential, and give each test a deadline."""
    draw.keep_drawn(config, items)
    for item in items:
        if item.get_closest_marker("timeout") is None:
            long = any(map(item.get_closest_marker, ("slow", "realtime", "vcan")))
            deadline = _SLOW_DEADLINE if long else _DEADLINE
            item.add_marker(pytest.mark.timeout(patient(deadline)))


def pytest_runtest_setup() -> None:
    """Listen to Ctrl-C, which some tests send to themselves.

    A shell lets what it starts in the background ignore it, and so does a run that a signal has ended.
    """
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_finish() -> None:
    """Take what thousands of collected tests hold out of garbage collection.

    A run of the drives collects garbage before it begins. With all tests in the same process that took 0.2 s, and a
    simulated machine in real time began late.
    """
    gc.collect()
    gc.freeze()


@pytest.fixture
def no_collection() -> Iterator[None]:
    """Keep garbage collection out of a test that interrupts itself: its callbacks swallow an interrupt."""
    gc.disable()
    yield
    gc.enable()


@dataclass(frozen=True)
class Finished:
    """Exit code and output of a command."""

    code: int
    out: str
    err: str

    @property
    def figures(self) -> Any:
        """The JSON document of a command that succeeded."""
        assert self.code == 0, self.err
        return json.loads(self.out)


Runner = Callable[..., Finished]


def launcher(program: str) -> list[str]:
    """Beginning of a command line that runs `daq` or `ident` of this checkout."""
    return [sys.executable, "-W", "error", "-c", f"from {program}.cli import main; main()"]


def _runner(program: str, folder: Path) -> Runner:
    def run(*arguments: object) -> Finished:
        done = subprocess.run(
            [*launcher(program), *map(str, arguments)],
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=patient(900),
        )
        assert "Traceback" not in done.stderr, done.stderr
        return Finished(done.returncode, done.stdout, done.stderr)

    return run


@pytest.fixture
def daq(tmp_path: Path) -> Runner:
    """Run `daq` in a temporary folder."""
    return _runner("daq", tmp_path)


@pytest.fixture
def in_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> Callable[[str], Runner]:
    """Return a function that gives the runner of a program without a process, which takes a second to start."""
    monkeypatch.chdir(tmp_path)

    def runner(program: str) -> Runner:
        main = importlib.import_module(f"{program}.cli").main

        def run(*arguments: object) -> Finished:
            monkeypatch.setattr(sys, "argv", [program, *map(str, arguments)])
            with pytest.raises(SystemExit) as end:
                main()
            return Finished(int(end.value.code or 0), *capfd.readouterr())

        return run

    return runner


@pytest.fixture
def daq_in_process(in_process: Callable[[str], Runner], monkeypatch: pytest.MonkeyPatch) -> Runner:
    """Run `daq` in this process."""
    from canopen.sdo import SdoClient

    # A simulated drive in a process of many tests may be late, a lost one is not.
    monkeypatch.setattr(SdoClient, "RESPONSE_TIMEOUT", patient(5.0))
    return in_process("daq")


@pytest.fixture
def ident_in_process(in_process: Callable[[str], Runner], monkeypatch: pytest.MonkeyPatch) -> Runner:
    """Run `ident` in this process."""
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")  # which it would set for good
    return in_process("ident")


@pytest.fixture
def ident(tmp_path: Path) -> Runner:
    """Run `ident` in a temporary folder."""
    return _runner("ident", tmp_path)
