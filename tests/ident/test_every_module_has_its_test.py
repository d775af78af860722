"""Every module of the statistical core has a test of its own, which imports it directly."""

import ast
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
SOURCE = TESTS.parents[1] / "ident"
ROOMS = ("data", "estimation", "uncertainty", "residuals", "diagnosis")


def runs_something(path: Path) -> bool:
    """Whether the module has a function or property with a result; data and protocols alone have nothing to test."""
    return any(isinstance(node, ast.Return | ast.Yield | ast.Raise) for node in ast.walk(ast.parse(path.read_text())))


MODULES = [
    path.relative_to(SOURCE)
    for room in ROOMS
    for path in sorted((SOURCE / room).glob("*.py"))
    if path.name != "__init__.py" and runs_something(path)
]


def imported(path: Path) -> set[str]:
    """Full names of the modules, and of what is taken from them, that `path` imports."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return names


@pytest.mark.parametrize("module", MODULES, ids=str)
def test_module_is_imported_by_the_test_of_its_name(module: Path) -> None:
    test = TESTS / module.parent / f"test_{module.name}"
    assert test.exists(), f"{test} expected"
    assert ".".join(("ident", *module.with_suffix("").parts)) in imported(test)
