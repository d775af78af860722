"""`tests/vcan/run` without User-mode Linux: what it says where that dies, and the help for processors with AMX."""

import ctypes
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import Finished

VCAN = Path(__file__).parent / "vcan"
_NEEDED = ("ip", "candump", "cansend", "cangen", "insmod")
"""Looked for, but not run."""
_DIES = (
    'echo "preloaded: $LD_PRELOAD"\nfor i in $(seq 50); do echo "kernel $i" >&3; done\necho "own words" >&2\nexit 1'
)

needs_compiler = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")


def _run(folder: Path, programs: dict[str, str], **environment: str) -> Finished:
    """`tests/vcan/run` with these programs, as shell scripts, before all others."""
    for name, script in {**dict.fromkeys(_NEEDED, ""), "df": "echo 9999", "linux.uml": _DIES, **programs}.items():
        (folder / name).write_text(f"#!/bin/sh\n{script}\n")
        (folder / name).chmod(0o755)
    path = f"{folder}:{os.environ['PATH']}"
    settings = {"PATH": path, "PYTHON": sys.executable, "VCAN_UML": "1", **environment}
    done = subprocess.run(
        [VCAN / "run", folder / "out"], env=os.environ | settings, capture_output=True, text=True, timeout=60
    )
    return Finished(done.returncode, done.stdout, done.stderr)


def test_where_user_mode_linux_dies_its_last_words_are_shown(tmp_path: Path) -> None:
    done = _run(tmp_path, {})
    assert done.code == 1
    assert "ended without a result" in done.err
    assert "kernel 50\nown words\n" in done.err
    assert "kernel 1\n" not in done.err


def test_with_amx_a_missing_compiler_is_named(tmp_path: Path) -> None:
    done = _run(tmp_path, {"cc": "exit 127"}, VCAN_AMX="1")
    assert done.code == 2
    assert "C compiler (cc)" in done.err
    assert "apt-get install gcc libc6-dev" in done.err


@needs_compiler
def test_with_amx_the_help_is_preloaded(tmp_path: Path) -> None:
    done = _run(tmp_path, {}, VCAN_AMX="1")
    assert f"preloaded: {tmp_path}/out/amx_ptrace.so\n" in done.out


@needs_compiler
def test_a_state_that_is_cut_short_is_taken_with_the_help_only(tmp_path: Path) -> None:
    library = tmp_path / "amx_ptrace.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-O2", "-o", library, VCAN / "amx_ptrace.c"], check=True)
    with subprocess.Popen(["sleep", "60"]) as process:
        plain, helped = _Traced(process.pid, None), _Traced(process.pid, library)
        try:
            if plain.call(_ATTACH) != 0:
                pytest.skip("no program may trace another one here")
            os.waitpid(process.pid, os.WUNTRACED)
            state = plain.floating_point()
            assert plain.set_floating_point(state[:-64]) == -1
            assert helped.set_floating_point(state[:-64]) == 0
            assert helped.set_floating_point(state) == 0
            assert helped.floating_point() == state
            assert helped.set_floating_point(state + bytes(64)) == plain.set_floating_point(state + bytes(64))
        finally:
            process.kill()


# Of sys/ptrace.h and elf.h.
_ATTACH, _GETREGSET, _SETREGSET, _XSTATE = 16, 0x4204, 0x4205, 0x202


class _Iovec(ctypes.Structure):
    _fields_ = (("base", ctypes.c_void_p), ("length", ctypes.c_size_t))


class _Traced:
    """A process as `ptrace` of a library, or of the C library, sees it."""

    def __init__(self, pid: int, library: Path | None) -> None:
        self._pid = pid
        self._ptrace = ctypes.CDLL(None if library is None else str(library)).ptrace
        self._ptrace.argtypes = (ctypes.c_long, ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)
        self._ptrace.restype = ctypes.c_long

    def call(self, request: int, address: int = 0, data: object = None) -> int:
        return int(self._ptrace(request, self._pid, address, data))

    def floating_point(self) -> bytes:
        buffer = ctypes.create_string_buffer(65536)
        room = _Iovec(ctypes.addressof(buffer), len(buffer))
        assert self.call(_GETREGSET, _XSTATE, ctypes.addressof(room)) == 0
        return buffer.raw[: room.length]

    def set_floating_point(self, state: bytes) -> int:
        buffer = ctypes.create_string_buffer(state, len(state))
        given = _Iovec(ctypes.addressof(buffer), len(state))
        return self.call(_SETREGSET, _XSTATE, ctypes.addressof(given))
