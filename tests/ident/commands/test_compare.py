"""`ident compare` as a user types it."""

import json
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


def test_json_is_one_document_with_the_documented_keys(folder: Path) -> None:
    result = run("compare", folder / "a.model.json", folder / "b.mcap", "--json")
    document = json.loads(result.stdout)
    assert not [*folder.glob("*.compare.html")], "none unless it is asked for"
    assert document["schema"] == 2
    assert document["recordings"] == ["b.mcap"]
    assert document["bandwidth_hz"] == 30
    assert len(document["joints"]) == 3
    joint = document["joints"][0]
    assert set(joint) == {
        *("joint", "unit", "rms", "rms_all", "share_of_torque", "noise_rms", "repetition_rms", "above_noise"),
        *("phases", "curves", "influence", "spectrum"),
    }
    assert set(joint["curves"]) == {"velocity", "position", "load", "time", "cycle"}
    assert set(joint["curves"]["load"]) == {"unit", "explained", "centre", "mean", "half_width", "rms", "samples"}
    assert sum(phase["time_share"] for phase in joint["phases"].values()) == pytest.approx(1)
    assert {"joint", "start", "end", "rms", "phase", "cycle"} <= set(document["windows"][0])
    assert set(joint["influence"]) == {"variable", "joint", "reverses", "periods", "explained"}
    assert document["where"]


def test_an_interruption_leaves_no_partial_page(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("ident.output.figures.torque.worst_windows", interrupted)
    before = sorted(folder.iterdir())
    result = run("compare", folder / "a.model.json", folder / "b.mcap", "--report", folder / "half.html")
    assert result.exit_code == 1
    assert sorted(folder.iterdir()) == before
