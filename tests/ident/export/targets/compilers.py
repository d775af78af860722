"""C compilers for tests: without one they are skipped, but not in CI."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic")
SANITIZERS = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all")


def need(compiler: str) -> None:
    """Skip the test without `compiler`; fail in CI."""
    if shutil.which(compiler) is None:
        if os.environ.get("CI") == "true":
            pytest.fail(f"{compiler} expected in CI, none found; apt-get install {compiler}")
        pytest.skip(f"needs {compiler}")


def compile_c(compiler: str, sources: list[Path], out: Path, *options: str) -> Path:
    """Compile the `sources` to `out`; a warning is an error."""
    need(compiler)
    words = [compiler, *STRICT, "-O2", *options, *map(str, sources), "-lm", "-o", str(out)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return out
