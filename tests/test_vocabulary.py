"""Names in the code are the standard terms of docs/glossary.md; the words that they replaced do not come back."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.documents import ROOT

IDENT = {
    "course": "prepared recording",
    "dataset": "prepared recording",
    "path": "mechanism motion",
    "view": "effect inputs",
    "calmed": "low-passed",
    "where": "residual phases",
    "refine": "nonlinear least squares",
    "frozen": "regression",
    "settle": "fit shape parameters",
    "evaluation": "predicted torque",
    "evaluator": "torque predictor",
    "forearms": "rods",
    "arms": "flexible joints",
    "arm_loops": "flexible joint kernels",
    "flights": "backlash screening",
    "on_springs": "elastic torque",
    "with_play": "backlash torque",
    "swings": "natural frequencies",
    "falls": "cost reductions",
    "parts": "substeps, topics",
    "stand_in": "learned (nonparametric) curve",
    "trust": "assessment",
    "plausibility": "physical consistency",
    "fitness": "goodness of fit",
    "repetition": "cycle statistics",
    "discovery": "plugins",
    "composition": "model structure",
    "named": "parameter entry",
    "own": "local parameters",
    "owners": "instances",
    "starts": "initial guesses",
    "valleys": "multistart",
    "always_true": "mandatory",
    "looks": "symptom",
    "never": "inf",
    "climber": "selector",
    "climb": "selection state",
    "rung": "step",
    "rungs": "steps",
    "by_hand": "forced",
    "options": "candidates",
    "finder": "candidate search",
    "material": "split data",
    "seen": "train",
    "held": "test",
    "misread": "perturbed",
    "misled": "attenuation bias",
    "faithful": "without saturated rows",
    "silent": "insensitive",
    "remainder": "unexplained residual",
    "dependence": "residual dependence",
    "learning": "nonparametric fit",
    "unknown": "misspecification check",
    "beyond": "extrapolation",
    "doubt": "warning",
    "doubts": "warnings",
    "directions": "friction-offset confounding",
    "removal": "effect contribution",
    "signature": "binned residual",
    "rivals": "discrimination",
    "told_apart": "discriminability",
    "foretaste": "preview",
    "look": "recording view",
    "posture": "pose",
    "opening": "startup",
    "swarming": "PSO task",
    "failing": "residual task",
    "script": "CLI equivalent",
    "region": "time span",
    "work": "worker",
    "ladder": "stepwise selection",
}
DRIVERS = {
    "strangers": "unexpected nodes",
    "examine": "check",
    "finding": "check result",
    "entry": "SDO write",
    "control": "controlword",
    "remainder": "base-model residual",
    "ruler": "effect sizer",
    "search": "secant",
    "outside": "out of library",
    "profile": "setpoint generator",
}
LOCALS = {"one", "found", "own", "left"}
"""Name nothing: a variable is called after what it holds."""
KEPT = {
    "ident/dynamics/effects/earlier_files.py": "translates the names of files that users wrote with earlier versions",
    "ident/output/figures/ladder.py": "the figure is called a ladder on the page",
    "ident/workbench/plots.py": "likewise",
    "ident/workbench/branches.py": "likewise",
    "ident/workbench/model_selection.py": "likewise",
}


def sources(*rooms: str) -> list[Path]:
    """The modules of `rooms`, relative to the root."""
    return sorted(path.relative_to(ROOT) for room in rooms for path in (ROOT / room).rglob("*.py"))


def definitions(path: Path) -> Iterator[str]:
    """Names of the module and of its classes and functions, as words with underscores."""
    yield path.stem
    for node in ast.walk(ast.parse((ROOT / path).read_text(encoding="utf-8"))):
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            yield re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", node.name).lower().strip("_")


def variables(path: Path) -> Iterator[str]:
    """Names of local variables and parameters."""
    for node in ast.walk(ast.parse((ROOT / path).read_text(encoding="utf-8"))):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id
        elif isinstance(node, ast.arg):
            yield node.arg


@pytest.mark.parametrize(("room", "words"), [("ident", IDENT), ("drivers", DRIVERS)])
def test_modules_classes_and_functions_have_standard_names(room: str, words: dict[str, str]) -> None:
    wrong = [
        f"{path}: {name}; say {words[name]}"
        for path in sources(room)
        if path.as_posix() not in KEPT
        for name in definitions(path)
        if name in words
    ]
    assert not wrong, "\n".join(wrong)


def test_variables_say_what_they_hold() -> None:
    rooms = ("daq", "drivers", "ident", "recordings", "trajectories", "web", "benchmarks", "tests")
    wrong = [
        f"{path}: {sorted(LOCALS & names)}"
        for path in sources(*rooms)
        if "old_files" not in path.parts
        for names in [set(variables(path))]
        if LOCALS & names and path.as_posix() != "drivers/protocol.py"  # `found` is a JSON field of `daq check`
    ]
    assert not wrong, "\n".join(wrong)


def test_a_name_of_the_old_kind_is_noticed(tmp_path: Path) -> None:
    module = tmp_path / "posture.py"
    module.write_text("class StandIn:\n    def _told_apart(self, one):\n        left = one\n")
    assert set(definitions(module)) == {"posture", "stand_in", "told_apart"}
    assert LOCALS & set(variables(module)) == {"one", "left"}


def test_the_root_of_ident_holds_what_nothing_else_owns() -> None:
    modules = {path.stem for path in (ROOT / "ident").glob("*.py")} - {"__init__"}
    assert modules == {
        "cli", "command_options", "filters", "model_name", "numba_cache", "plugins", "recent", "slicing", "threads"
    }  # fmt: skip
