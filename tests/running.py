"""Observe a run through the output of `daq record --status`."""

import json
import socket
import subprocess
from collections.abc import Iterable
from typing import Any


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


def free_port() -> int:
    """UDP port that is free now."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("", 0))
        port: int = probe.getsockname()[1]
        return port
