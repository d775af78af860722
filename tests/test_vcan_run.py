"""`tests/vcan/run` without User-mode Linux: errors, and the workaround for processors with AMX."""

import ctypes
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import Finished
from tests.patience import patient

VCAN = Path(__file__).parent / "vcan"
_NEEDED = ("ip", "candump", "cansend", "cangen", "insmod")
"""Programs that must exist but are not run."""
_FAILING_KERNEL = (
    'echo "preloaded: $LD_PRELOAD"\nfor i in $(seq 50); do echo "kernel $i" >&3; done\necho "own words" >&2\nexit 1'
)

needs_compiler = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")


def _run(folder: Path, programs: dict[str, str], **environment: str) -> Finished:
    """Run `tests/vcan/run` with `programs` (shell scripts by name) first in the path."""
    for name, script in {
        **dict.fromkeys(_NEEDED, ""),
        "df": "echo 9999",
        "linux.uml": _FAILING_KERNEL,
        **programs,
    }.items():
        (folder / name).write_text(f"#!/bin/sh\n{script}\n")
        (folder / name).chmod(0o755)
    path = f"{folder}:{os.environ['PATH']}"
    settings = {"PATH": path, "PYTHON": sys.executable, "VCAN_UML": "1", **environment}
    done = subprocess.run(
        [VCAN / "run", folder / "out"], env=os.environ | settings, capture_output=True, text=True, timeout=patient(60)
    )
    return Finished(done.returncode, done.stdout, done.stderr)


def test_last_lines_of_a_failed_user_mode_linux_are_shown(tmp_path: Path) -> None:
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
def test_with_amx_the_workaround_is_preloaded(tmp_path: Path) -> None:
    done = _run(tmp_path, {}, VCAN_AMX="1")
    assert f"preloaded: {tmp_path}/out/amx_ptrace.so\n" in done.out


@needs_compiler
def test_truncated_register_state_is_accepted_only_with_the_workaround(tmp_path: Path) -> None:
    library = tmp_path / "amx_ptrace.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-O2", "-o", library, VCAN / "amx_ptrace.c"], check=True)
    with subprocess.Popen(["sleep", "60"]) as process:
        plain, patched = _Traced(process.pid, None), _Traced(process.pid, library)
        try:
            if plain.call(_ATTACH) != 0:
                pytest.skip("no program may trace another one here")
            os.waitpid(process.pid, os.WUNTRACED)
            state = plain.floating_point()
            assert plain.set_floating_point(state[:-64]) == -1
            assert patched.set_floating_point(state[:-64]) == 0
            assert patched.set_floating_point(state) == 0
            assert patched.floating_point() == state
            assert patched.set_floating_point(state + bytes(64)) == plain.set_floating_point(state + bytes(64))
        finally:
            process.kill()


# Constants of sys/ptrace.h and elf.h.
_ATTACH, _GETREGSET, _SETREGSET, _XSTATE = 16, 0x4204, 0x4205, 0x202


class _Iovec(ctypes.Structure):
    _fields_ = (("base", ctypes.c_void_p), ("length", ctypes.c_size_t))


class _Traced:
    """Process traced by `ptrace` of a `library`, or of the C library if None."""

    def __init__(self, pid: int, library: Path | None) -> None:
        self._pid = pid
        self._ptrace = ctypes.CDLL(None if library is None else str(library)).ptrace
        self._ptrace.argtypes = (ctypes.c_long, ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)
        self._ptrace.restype = ctypes.c_long

    def call(self, request: int, address: int = 0, data: object = None) -> int:
        return int(self._ptrace(request, self._pid, address, data))

    def floating_point(self) -> bytes:
        buffer = ctypes.create_string_buffer(65536)
        vector = _Iovec(ctypes.addressof(buffer), len(buffer))
        assert self.call(_GETREGSET, _XSTATE, ctypes.addressof(vector)) == 0
        return buffer.raw[: vector.length]

    def set_floating_point(self, state: bytes) -> int:
        buffer = ctypes.create_string_buffer(state, len(state))
        vector = _Iovec(ctypes.addressof(buffer), len(state))
        return self.call(_SETREGSET, _XSTATE, ctypes.addressof(vector))
