"""The page docs/explanation/constants.md, made from the docstrings of constants by `make docs-output`."""

import ast
import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

from tests.documents import ROOT

PAGE = ROOT / "docs" / "explanation" / "constants.md"
ROOMS = (
    "data",
    "data_problems",
    "diagnosis",
    "estimation",
    "fleet",
    "residuals",
    "sequential",
    "uncertainty",
    "watch",
)
_GUARDS = {"_TINY", "TINY", "_SEED"}
"""Guards against division by zero, and seeds, shape no verdict."""
_INTRODUCTION = """# The constants behind a verdict

Every threshold is a named constant with its reason beside it in the code. This page is made from these docstrings, by
module. Shares, ratios and counts have no unit; the others say theirs.

The constants were chosen on the simulated rig and checked on a plant that shares nothing with it
([how often it is right](accuracy.md)). They are the same for every robot; none is a setting.
"""


def page() -> str:
    """The text of the page."""
    parts = [_INTRODUCTION]
    of_rooms = [path for room in ROOMS for path in sorted((ROOT / "ident" / room).rglob("*.py"))]
    for path in [*of_rooms, ROOT / "ident" / "basics" / "statistics.py"]:
        rows = list(_rows(path))
        if rows:
            module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
            parts.append(
                "\n".join([f"\n## `{module}`\n", "| name | value | meaning |", "|---|---|---|", *rows]) + "\n"
            )
    return "".join(parts)


def _rows(path: Path) -> Iterator[str]:
    """Yield a row of the table for each numeric constant of a module with a docstring."""
    body = ast.parse(path.read_text(encoding="utf-8")).body
    for statement, docstring in pairwise(body):
        if isinstance(statement, ast.Assign | ast.AnnAssign) and isinstance(docstring, ast.Expr):
            target = statement.targets[0] if isinstance(statement, ast.Assign) else statement.target
            names = [each.id for each in ast.walk(target) if isinstance(each, ast.Name)]
            value, text = ast.unparse(statement.value or target), docstring.value
            is_constant = all(re.fullmatch("_?[A-Z][A-Z0-9_]*", name) for name in names) and not _GUARDS & set(names)
            if is_constant and re.match(r"[-(\d{]", value) and isinstance(text, ast.Constant):
                meaning = " ".join(str(text.value).split()).replace("|", "\\|")
                yield f"| `{', '.join(names)}` | {value} | {meaning} |"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
