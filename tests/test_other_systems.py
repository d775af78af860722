"""What Windows or macOS lack is not needed where it is not used: the programs start, and `ident` works without it."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from daq.bench import Bench
from recordings.buses import CanBus
from recordings.errors import BadInput
from recordings.rig import simulated_rig

SAMPLE = Path(__file__).parents[1] / "recordings" / "samples" / "fig5a.mcap"
WITHOUT = """
import os, signal, sys
for name in ("fcntl", "termios", "tty", "pty", "grp", "pwd", "resource"):
    sys.modules[name] = None
import threading, asyncio, subprocess  # these of the library itself are as they are there
for name in ("SIGHUP", "SIGSTOP", "SIGCONT", "SIGUSR1", "SIGUSR2"):
    delattr(signal, name)
for name in ("openpty", "sched_setscheduler", "sched_param", "killpg", "fork"):
    delattr(os, name)
"""


def without_unix(code: str) -> subprocess.CompletedProcess[str]:
    """Run `code` in a Python from which such names are gone."""
    return subprocess.run([sys.executable, "-c", WITHOUT + code], capture_output=True, text=True, check=False)


def test_every_command_can_be_imported() -> None:
    done = without_unix(
        "import click\n"
        "from daq.program import program as daq\n"
        "from ident.program import program as ident\n"
        "for program in (daq, ident):\n"
        "    context = click.Context(program)\n"
        "    for name in program.list_commands(context):\n"
        "        program.get_command(context, name)\n"
    )
    assert done.returncode == 0, done.stderr


def test_a_model_is_fitted(tmp_path: Path) -> None:
    out = tmp_path / "model.json"
    done = without_unix(
        f"from ident.program import program\nprogram(['fit', {str(SAMPLE)!r}, '--method', 'wls', '-o', {str(out)!r}])"
    )
    assert done.returncode == 0, done.stderr
    assert out.is_file()


def test_real_drives_do_not_move_where_nothing_can_ask_to_stop(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = simulated_rig()
    real = Bench.of(rig.model_copy(update={"bus": CanBus(interface="socketcan", channel="can0")}))
    real.announce("a motion")
    monkeypatch.delattr(signal, "SIGHUP")
    Bench.of(rig).announce("a motion")
    with pytest.raises(BadInput, match="asked to stop, as Linux, expected"):
        real.announce("a motion")
