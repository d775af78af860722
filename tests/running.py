"""Commands that run in the process of a test, and programs that run beside it: `daq record --status`, `daq sim`."""

import itertools
import json
import os
import socket
import subprocess
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import click
import pytest
from click.testing import CliRunner, Result

from recordings.errors import BadInput
from recordings.reader import read, read_can
from recordings.recording import CanFrames, Recording
from tests.conftest import launcher

DRIVES = "".join(f"[[drives]]\nnode_id = {node}\n" for node in (1, 2, 3))
"""Drives of a rig file with three joints."""


def invoke(command: click.Command, *arguments: object) -> Result:
    """Run a `command` in this process."""
    return CliRunner().invoke(command, [str(argument) for argument in arguments])


def ran(command: click.Command, *arguments: object) -> Result:
    """Run a `command` in this process, which succeeds.

    Raises:
        BadInput: the command refuses its arguments.
    """
    result = invoke(command, *arguments)
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    if result.exit_code:
        raise BadInput(result.output)
    return result


def printed(command: click.Command, *arguments: object) -> str:
    """Standard output of a `command` that succeeds; errors as `ran`."""
    return ran(command, *arguments).stdout


def wait_until_moving(process: "subprocess.Popen[str]", cycles: int = 250) -> bool:
    """Wait until the motion has lasted for `cycles`; return False if the run ends before."""
    assert process.stdout is not None
    return any(_is_moving(line, cycles) for line in process.stdout)


def _is_moving(line: str, cycles: int) -> bool:
    status = json.loads(line)
    return bool(status.get("status") == "stream" and status["done"] >= cycles)


def last_told(lines: Iterable[str]) -> dict[str, Any]:
    """Last status of a run, however it ended; empty if there is none."""
    statuses = [json.loads(line) for line in lines if line.startswith('{"status"')]
    return statuses[-1] if statuses else {}


_WORKER = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
_PORTS = itertools.cycle(range(20_000 + 500 * _WORKER, 20_500 + 500 * _WORKER))
"""Ports of this worker alone, below those that the system gives to anybody."""


def first_fast(values: Iterable[Any]) -> list[Any]:
    """Parameters of a test that takes seconds: the first is fast, the others are slow."""
    first, *others = values
    return [first, *(pytest.param(value, marks=pytest.mark.slow) for value in others)]


def free_port(kind: socket.SocketKind = socket.SOCK_DGRAM) -> int:
    """A port that nobody uses, and no other worker gets; of UDP unless another kind is asked for."""
    for port in _PORTS:
        with socket.socket(socket.AF_INET, kind) as probe, suppress(OSError):
            probe.bind(("", port))
            return port
    raise AssertionError


def udp_bus() -> str:
    """Bus of a rig file that other programs on this machine can reach."""
    return f'[bus]\ninterface = "udp_multicast"\nchannel = "239.74.163.2"\nport = {free_port()}\n'


@contextmanager
def served(folder: Path, *arguments: object) -> Iterator["subprocess.Popen[str]"]:
    """Run `daq sim` until the end of the block, which begins when it is ready; it ends orderly, or with us."""
    command = [*launcher("daq"), "sim", "--until-eof", *map(str, arguments)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, cwd=folder, text=True, stdin=pipe, stdout=pipe, stderr=pipe) as process:
        assert process.stdout is not None
        assert "simulated drives" in process.stdout.readline()
        try:
            yield process
        finally:
            process.terminate()
    assert process.returncode == 0


def accounted_for(path: Path, figures: dict[str, Any]) -> tuple[Recording, CanFrames]:
    """The samples and frames of a run in real time, whose `figures` account for every cycle and answer."""
    recording, frames = read(path), read_can(path)
    assert len(recording.time) == figures["cycles"] + figures["cycles_missed"]
    assert recording.gaps.sum() == figures["answers_lost"] + 3 * figures["cycles_missed"]
    return recording, frames
