"""Cases of the golden results: the sample recordings and six cases of the foreign benchmark."""

import hashlib
import json
import os
import re
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

Documents = dict[str, Any]
"""Documents that the commands printed or wrote, by name."""

HERE = Path(__file__).parents[2]
CACHE = HERE / "runs" / "golden"
_RECORDERS = (
    "benchmarks/hidden_effects",
    "daq",
    "drivers",
    "recordings",
    "tests/drivers",
    "tests/foreign",
    "trajectories",
)
"""Folders whose code determines the recordings of the benchmark: after a change they are recorded again."""
_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.])")


@dataclass(frozen=True)
class Case:
    """Two recordings and the commands that are run on them."""

    name: str
    benchmark: str | None = None
    """Name of the case in the benchmark; None: the sample recordings."""
    alone: bool = False
    """Whether the first recording is also diagnosed alone."""


CASES = (
    Case("samples", alone=True),
    Case("nothing", "nothing-default-18bit-500Hz-13"),
    Case("additive", "single-stribeck-3%-default-1"),
    Case("stateful", "single-backlash-3%-default-1"),
    Case("signal", "single-amplifier_saturation-3%-default-1"),
    Case("pair", "pair-stribeck-3%+actuation_delay-3%-heavy-59"),
    Case("outside", "outside-uneven_grease-3%-default-1"),
)


class CommandFailed(RuntimeError):
    """A command failed."""


@dataclass(frozen=True)
class Code:
    """A checkout whose commands are run."""

    root: Path

    def run(self, *arguments: object) -> str:
        """Run Python with the packages of this checkout; return its output."""
        threads = {f"{library}_NUM_THREADS": "1" for library in ("OPENBLAS", "OMP", "MKL", "NUMBA")}
        done = subprocess.run(
            [sys.executable, *map(str, arguments)],
            cwd=self.root,
            env=os.environ | threads | {"PYTHONPATH": str(self.root)},
            capture_output=True,
            text=True,
        )
        if done.returncode:
            raise CommandFailed(f"{' '.join(map(str, arguments[2:4]))}: {(done.stderr.splitlines() or ['?'])[-1]}")
        return done.stdout

    def ident(self, *arguments: object) -> Any:
        """Document that a command of `ident` prints."""
        return json.loads(self.run("-c", "from ident.cli import main; main()", *arguments, "--json"))

    def recordings(self, case: Case) -> tuple[Path, Path]:
        """Paths of the training and the validation recording."""
        if case.benchmark is None:
            folder = self.root / "recordings" / "samples"
            return folder / "fig5a.mcap", folder / "fig5b.mcap"
        folder = self.cache() / case.benchmark
        return folder / "train.mcap", folder / "validate.mcap"

    def record(self, selected: Sequence[Case], jobs: int) -> None:
        """Create the missing recordings of the benchmark."""
        names = [case.benchmark for case in selected if case.benchmark]
        if all((self.cache() / name).exists() for name in names):
            return
        only = [word for name in names for word in ("--only", name)]
        options = ["--plant", "foreign", "--stage", "record", "--folder", self.cache()]
        self.run("-m", "benchmarks.hidden_effects", *options, "--jobs", jobs, *only)

    def cache(self) -> Path:
        """Folder of the recordings, which depends on the code of this checkout."""
        digest = hashlib.sha256()
        for path in sorted(path for package in _RECORDERS for path in (self.root / package).rglob("*.py")):
            digest.update(str(path.relative_to(self.root)).encode() + path.read_bytes())
        return CACHE / digest.hexdigest()[:12]


def documents(case: Case, code: Code, folder: Path) -> Documents:
    """All documents of a case; `folder` must be empty and receives the files of the commands."""
    train, validate = code.recordings(case)
    model, better, curves = folder / "model.json", folder / "better.json", folder / "learned_curve.py"
    results: Documents = {"fit": code.ident("fit", train, "--validate", validate, "-o", model)}
    results["model"] = json.loads(model.read_text(encoding="utf-8"))
    results["compare"] = code.ident("compare", model, validate)
    held_out = ["--validate", validate, "--apply", "-o", better, "--learn", curves]
    results["diagnose"] = code.ident("diagnose", train, *held_out)
    results["better_model"] = json.loads(better.read_text(encoding="utf-8"))
    results["learned_curve"] = numbers(curves.read_text(encoding="utf-8")) if curves.exists() else None
    if case.alone:
        results["diagnose_alone"] = code.ident("diagnose", train)
    return results


def numbers(source: str) -> list[float]:
    """All numbers in the source text of a program."""
    return [float(number) for number in _NUMBER.findall(source)]
