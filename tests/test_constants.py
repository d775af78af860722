"""The page of constants agrees with the code."""

import ast
import importlib
import re
from pathlib import Path

import pytest

from tests.documents import ROOT

PAGE = ROOT / "docs" / "explanation" / "constants.md"
NO_THRESHOLDS = {"_TINY", "_SEED"}
"""Guards against division by zero, and seeds."""


def listed() -> list[tuple[str, str, str]]:
    """Module, name and value of each row of the page."""
    module, rows = "", []
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        if heading := re.fullmatch(r"### `([\w.]+)`", line):
            module = heading[1]
        elif row := re.match(r"\| `(\w+)` \| (.+?) \| ", line):
            rows.append((module, row[1], row[2]))
    return rows


@pytest.mark.parametrize(("module", "name", "value"), listed())
def test_listed_value_is_that_of_the_code(module: str, name: str, value: str) -> None:
    assert getattr(importlib.import_module(module), name) == ast.literal_eval(value)


@pytest.mark.parametrize("path", sorted((ROOT / "ident" / "diagnosis").glob("*.py")), ids=lambda path: path.stem)
def test_every_constant_of_a_diagnosis_is_listed(path: Path) -> None:
    module = f"ident.diagnosis.{path.stem}"
    constants = {
        name
        for name, value in vars(importlib.import_module(module)).items()
        if isinstance(value, (int, float, tuple)) and re.search(rf"^{name} = ", path.read_text(), re.MULTILINE)
    }
    assert constants <= {name for row_module, name, _ in listed() if row_module == module} | NO_THRESHOLDS
