"""C compilers for tests, and what they compile: without one, tests are skipped, but not in CI."""

import ctypes
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from recordings.recording import Floats

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Werror")
SANITIZERS = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all")


def need(*programs: str) -> None:
    """Skip the test without one of the `programs`; fail in CI."""
    for program in programs:
        if shutil.which(program) is None:
            if os.environ.get("CI") == "true":
                pytest.fail(f"{program} expected in CI, none found; install its package (.ci/run lists them)")
            pytest.skip(f"needs {program}")


def compile_c(compiler: str, sources: list[Path], out: Path, *options: str) -> Path:
    """Compile the `sources` to `out`; a warning is an error."""
    need(compiler)
    words = [compiler, *STRICT, "-O2", *options, *map(str, sources), "-lm", "-o", str(out)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return out


def compiled(folder: Path, compiler: str = "gcc") -> Path:
    """The exported code in `folder` as a shared object."""
    return compile_c(compiler, [folder / "delta_model.c"], folder / f"{compiler}.so", "-shared", "-fPIC")


class Stepped:
    """The compiled model."""

    def __init__(self, shared: Path, real: type[ctypes.c_double] | type[ctypes.c_float] = ctypes.c_double) -> None:
        self.code, self.real = ctypes.CDLL(str(shared)), real
        self.state = ctypes.create_string_buffer(4096)
        self.code.delta_model_init(self.state)

    def warm(self, celsius: list[float]) -> None:
        self.code.delta_model_temperature(self.state, (self.real * 3)(*celsius))

    def torque(self, q: Floats, qd: Floats, qdd: Floats, dt: float) -> Floats:
        result = np.empty_like(q)
        tau = (self.real * 3)()
        for k, row in enumerate(zip(q.tolist(), qd.tolist(), qdd.tolist(), strict=True)):
            arrays = [(self.real * 3)(*values) for values in row]
            self.code.delta_model_torque(self.state, *arrays, self.real(dt), tau)
            result[k] = list(tau)
        return result
