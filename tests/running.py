"""A run that is watched from outside, as `daq record --status` tells of it."""

import json
import socket
import subprocess
from collections.abc import Iterable
from typing import Any


def wait_until_moving(process: "subprocess.Popen[str]", cycles: int = 250) -> bool:
    """Until the motion has gone on for so many cycles; False where the run ends before."""
    assert process.stdout is not None
    return any(_moves(line, cycles) for line in process.stdout)


def _moves(line: str, cycles: int) -> bool:
    told = json.loads(line)
    return bool(told.get("status") == "stream" and told["done"] >= cycles)


def last_told(lines: Iterable[str]) -> dict[str, Any]:
    """The run's last status, which is there however it ended; empty where nothing was told."""
    told = [json.loads(line) for line in lines if line.startswith('{"status"')]
    return told[-1] if told else {}


def free_port() -> int:
    """A UDP port that nobody on this machine uses now."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("", 0))
        port: int = probe.getsockname()[1]
        return port
