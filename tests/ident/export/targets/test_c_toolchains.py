"""The C code is free of warnings in the compilers of controllers, and right on the processors that can be had."""

import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.ident.export.models import model_with
from tests.ident.export.targets.compilers import STRICT, need
from tests.ident.export.targets.test_c import DELTA, export
from tests.patience import patient
from tests.running import first_fast

CORTEX_M7 = ("-mcpu=cortex-m7", "-mfpu=fpv5-d16", "-mfloat-abi=hard")
BOARD = (
    "--specs=picolibc.specs", "--crt0=semihost", "--oslib=semihost", "-Tpicolibc.ld",
    "-Wl,--defsym=__flash=0,--defsym=__flash_size=0x400000,--defsym=__ram=0x20000000,--defsym=__ram_size=0x400000",
)  # fmt: skip
"""Of QEMU with a Cortex-M7, mps2-an500."""
QEMU = (
    "qemu-system-arm", "-M", "mps2-an500", "-display", "none", "-monitor", "none", "-serial", "none",
    "-semihosting-config", "enable=on,target=native,arg=test_vectors.csv", "-kernel",
)  # fmt: skip


@dataclass(frozen=True)
class Toolchain:
    """A compiler with its options, and what runs its programs; None: nothing here."""

    compiler: str
    options: tuple[str, ...] = ()
    linked: tuple[str, ...] = ()
    runs: tuple[str, ...] | None = None


TOOLCHAINS = {
    "gcc": Toolchain("gcc", runs=()),
    "clang": Toolchain("clang", runs=()),
    "32 bits": Toolchain("gcc", ("-m32",), runs=()),
    "musl": Toolchain("musl-gcc", linked=("-static",), runs=()),
    "mingw": Toolchain("x86_64-w64-mingw32-gcc"),
    "newlib": Toolchain("arm-none-eabi-gcc", (*CORTEX_M7, "--specs=rdimon.specs")),
    "picolibc": Toolchain("arm-none-eabi-gcc", CORTEX_M7, BOARD, QEMU),
}


@pytest.fixture(scope="module", params=["double", "float"])
def folder(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return export(model_with(DELTA), tmp_path_factory.mktemp("c"), request.param)


def run(folder: Path, *words: str) -> str:
    """What the command prints; QEMU prints what runs in it as errors."""
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False, timeout=patient(60))
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


@pytest.mark.parametrize("name", first_fast(TOOLCHAINS))
def test_it_compiles_without_warnings_and_gives_the_test_vectors(name: str, folder: Path) -> None:
    """The example's limits are 1e-12 and, in single precision, 1e-4 of the largest torque."""
    chain = TOOLCHAINS[name]
    need(chain.compiler)
    program = [*STRICT, "-O2", *chain.options, *chain.linked, "example.c", "delta_model.c", "-lm", "-o", "example"]
    run(folder, chain.compiler, *program)
    if chain.runs is not None:
        need(*chain.runs[:1])
        assert run(folder, *chain.runs, str(folder / "example")).startswith("1000 rows")


def test_single_precision_has_no_double_arithmetic(tmp_path: Path) -> None:
    """On a processor without double precision such arithmetic would be calls of __aeabi_d…"""
    need("arm-none-eabi-gcc")
    export(model_with(DELTA), tmp_path, "float", smooth_velocity=0.01)
    single = ("-mcpu=cortex-m7", "-mfpu=fpv5-sp-d16", "-mfloat-abi=hard")
    run(tmp_path, "arm-none-eabi-gcc", *STRICT, "-O2", *single, "-c", "delta_model.c")
    assert "__aeabi_d" not in run(tmp_path, "arm-none-eabi-nm", "delta_model.o")


def test_two_models_link_into_one_program_in_cpp(tmp_path: Path) -> None:
    need("g++")
    lines = []
    for side in ("left", "right"):
        (tmp_path / side).mkdir()
        export(model_with(["stribeck"]), tmp_path / side, prefix=side)
        run(tmp_path, "gcc", *STRICT, "-c", f"{side}/delta_model.c", "-o", f"{side}.o")
        lines.append(f'#include "{side}/delta_model.h"')
    lines += [
        "int main() {",
        "    left_state a; right_state b;",
        "    left_init(&a); right_init(&b);",
        "    return LEFT_DOF - RIGHT_DOF + (sizeof LEFT_DIGEST != sizeof RIGHT_DIGEST);",
        "}",
    ]
    (tmp_path / "main.cpp").write_text("\n".join(lines) + "\n")
    words = ("-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "main.cpp", "left.o", "right.o", "-lm")
    run(tmp_path, "g++", *words, "-o", "both")
    run(tmp_path, str(tmp_path / "both"))
