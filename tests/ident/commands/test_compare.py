"""`ident compare` as a user types it."""

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from ident.cli import program
from recordings.recording import Recording
from tests.running import invoke


@pytest.fixture(scope="module")
def folder(
    make: Callable[..., Recording], write: Callable[[Recording], Path], tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """A folder with a.mcap, b.mcap and a.model.json."""
    folder = tmp_path_factory.mktemp("recorded")
    write(make("fig5a", cycles=1, noise=0.01, path=folder / "a.mcap"))
    write(make("fig5b", cycles=2, noise=0.01, path=folder / "b.mcap"))
    fitted = run("fit", folder / "a.mcap", "--method", "ls")
    assert fitted.exit_code == 0, fitted.output
    return folder


run = partial(invoke, program)


def test_tables_and_page(folder: Path) -> None:
    page = folder / "both.html"
    result = run("compare", folder / "a.model.json", folder / "b.mcap", folder / "a.mcap", "--report", page)
    assert result.exit_code == 0, result.output
    for text in (
        "SIMULATED",
        "RELATIVE",
        "noise floor",
        "reversal",
        "cruise",
        "squared residual",
        "Worst intervals",
        "b.mcap",
    ):
        assert text in result.stdout
    shown = set(re.findall(r'data-figure="plot-([a-z0-9-]+)"', page.read_text(encoding="utf-8")))
    assert {"torque-1", "torque-2", "phases", "curves", "spectrum", "worst-1"} <= shown
