"""Record a case into a folder with train.mcap, validate.mcap and the sealed truth."""

import importlib
import json
import shutil
from dataclasses import asdict
from pathlib import Path

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


def record(case: HiddenCase, root: Path) -> str:
    """Create the complete folder of the case, or none; return a short text on the result."""
    from drivers.simulated.seal import seal, sealed_path

    partial = root / "partial" / case.name
    shutil.rmtree(partial, ignore_errors=True)
    partial.mkdir(parents=True)
    (partial / "case.json").write_text(json.dumps(asdict(case), indent=1), encoding="utf-8")
    try:
        plant = importlib.import_module(f"benchmarks.hidden_effects.{case.plant}")
        seal(sealed_path(partial / "train.mcap"), plant.record(case, partial))
        result = "recorded"
    except BadInput as error:
        (partial / IMPOSSIBLE).write_text(json.dumps({"why": str(error)}), encoding="utf-8")
        result = f"impossible: {error}"
    partial.rename(root / case.name)
    return result
