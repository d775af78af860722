"""Record a case into a folder with train.mcap, validate.mcap and the sealed truth."""

import importlib
import json
import shutil
from collections.abc import Iterable
from dataclasses import asdict
from functools import partial
from pathlib import Path

from benchmarks.hidden_effects import work
from benchmarks.hidden_effects.cases import HiddenCase
from recordings.errors import BadInput

IMPOSSIBLE = "impossible.json"
"""File in place of the recordings if the effect cannot have that size on that robot."""


def is_recorded(case: HiddenCase, root: Path) -> bool:
    """Whether the folder of the case exists."""
    return (root / case.name).is_dir()


def is_possible(case: HiddenCase, root: Path) -> bool:
    """Whether the effects of a recorded case can have their sizes on its robot."""
    return not (root / case.name / IMPOSSIBLE).exists()


def record_missing(cases: Iterable[HiddenCase], root: Path, jobs: int) -> None:
    """Record the `cases` that are not recorded yet, by so many `jobs` in parallel."""
    root.mkdir(parents=True, exist_ok=True)
    todo = [case for case in cases if not is_recorded(case, root)]
    for _ in work.run_all(partial(record, root=root), todo, jobs, "record"):
        pass


def record(case: HiddenCase, root: Path) -> str:
    """Create the complete folder of the case, or none; return a short text on the result."""
    from drivers.simulated.seal import seal, sealed_path

    unfinished = root / "partial" / case.name
    shutil.rmtree(unfinished, ignore_errors=True)
    unfinished.mkdir(parents=True)
    (unfinished / "case.json").write_text(json.dumps(asdict(case), indent=1), encoding="utf-8")
    try:
        plant = importlib.import_module(f"benchmarks.hidden_effects.{case.plant}")
        seal(sealed_path(unfinished / "train.mcap"), plant.record(case, unfinished))
        result = "recorded"
    except BadInput as error:
        (unfinished / IMPOSSIBLE).write_text(json.dumps({"why": str(error)}), encoding="utf-8")
        result = f"impossible: {error}"
    unfinished.rename(root / case.name)
    return result
