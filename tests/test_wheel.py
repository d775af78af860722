"""What `pip install` brings: all that the programs read, the samples too, and nothing that only the tests need."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from zipfile import ZipFile

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("daq", "drivers", "ident", "recordings", "trajectories", "delta_web")
BUILD = "import sys; from setuptools.build_meta import build_wheel; print(build_wheel(sys.argv[1]))"


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel of this checkout, built in a copy of it."""
    source, out = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("wheel")
    for package in PACKAGES:
        shutil.copytree(ROOT / package, source / package, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md"):
        shutil.copy(ROOT / name, source)
    built = subprocess.run([sys.executable, "-c", BUILD, str(out)], cwd=source, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr
    return out / built.stdout.splitlines()[-1]


def called(program: str) -> list[str]:
    """Beginning of a command line that runs `program` under its own name."""
    call = f"import sys; sys.argv[0] = {program!r}; from {program}.cli import main; main()"
    return [sys.executable, "-P", "-c", call]


def outside(wheel: Path, folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a program of the `wheel`, unpacked in `folder`, out of the repository."""
    installed = folder / "installed"
    ZipFile(wheel).extractall(installed)
    program, *words = arguments
    environment = {**os.environ, "PYTHONPATH": str(installed)}
    environment.pop("NUMBA_CACHE_DIR", None)
    return subprocess.run([*called(program), *words], cwd=folder, env=environment, capture_output=True, text=True)


def test_the_wheel_holds_every_file_of_the_packages(wheel: Path) -> None:
    files = [path.relative_to(ROOT) for package in PACKAGES for path in (ROOT / package).rglob("*") if path.is_file()]
    wanted = {path.as_posix() for path in files if "__pycache__" not in path.parts and "foreign" not in path.parts}
    assert {"recordings/samples/fig5a.mcap", "recordings/samples/fig5b.mcap"} < wanted
    assert {name for name in ZipFile(wheel).namelist() if ".dist-info/" not in name} == wanted


def test_both_programs_say_their_version(wheel: Path, tmp_path: Path) -> None:
    version = wheel.name.split("-")[1]
    for program in ("daq", "ident"):
        said = outside(wheel, tmp_path, program, "--version")
        assert (said.returncode, said.stdout) == (0, f"{program}, version {version}\n"), said.stderr


@pytest.mark.slow
def test_the_comparison_of_methods_runs_on_the_samples_outside_of_the_repository(wheel: Path, tmp_path: Path) -> None:
    done = outside(wheel, tmp_path, "ident", "table2", "--set", "pso.particles=10", "--set", "pso.neighbours=4")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "table2.plots").is_dir()


def test_a_shell_completes_commands_and_choices() -> None:
    for words, wanted in (("ident fi", "plain,fit"), ("ident fit --method pso_n", "plain,pso_nonlinear")):
        asked = {"_IDENT_COMPLETE": "bash_complete", "COMP_WORDS": words, "COMP_CWORD": str(words.count(" "))}
        done = subprocess.run(called("ident"), env={**os.environ, **asked}, capture_output=True, text=True)
        assert done.stdout.split() == [wanted], done.stderr
