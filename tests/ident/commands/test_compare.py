"""`ident compare` as a user types it."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from ident.cli import program
from recordings.errors import BadInput
from recordings.recording import Recording


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


def run(*arguments: object) -> Result:
    return CliRunner().invoke(program, [*map(str, arguments)], catch_exceptions=True)


def test_tables_and_pictures(folder: Path) -> None:
    result = run("compare", folder / "a.model.json", folder / "b.mcap", folder / "a.mcap", "--plots", folder / "both")
    assert result.exit_code == 0, result.output
    for text in (
        "SIMULATED",
        "RELATIVE",
        "Noise: differences",
        "reversal",
        "cruise",
        "depends on",
        "Worst stretches",
        "b.mcap",
    ):
        assert text in result.stdout
    assert sorted(path.name for path in (folder / "both").iterdir()) == [
        "curves.png",
        "phases.png",
        "residual_1.png",
        "residual_2.png",
        "spectrum.png",
        "worst.png",
    ]


def test_json_is_one_document_with_the_documented_keys(folder: Path) -> None:
    result = run("compare", folder / "a.model.json", folder / "b.mcap", "--json")
    document = json.loads(result.stdout)
    assert document["schema"] == 1
    assert document["recordings"] == ["b.mcap"]
    assert document["bandwidth_hz"] == 30
    assert len(document["joints"]) == 3
    joint = document["joints"][0]
    assert set(joint) == {
        *("joint", "unit", "rms", "share_of_torque", "noise_rms", "above_noise", "phases", "curves", "spectrum")
    }
    assert set(joint["curves"]) == {"velocity", "position", "load", "time", "cycle"}
    assert set(joint["curves"]["load"]) == {"unit", "explained", "centre", "mean", "half_width", "rms", "samples"}
    assert sum(phase["time_share"] for phase in joint["phases"].values()) == pytest.approx(1)
    assert {"joint", "start", "end", "rms", "phase", "cycle"} <= set(document["windows"][0])
    assert document["where"]


def test_pictures_are_kept_unless_forced(folder: Path) -> None:
    arguments = ("compare", folder / "a.model.json", folder / "a.mcap", "--plots", folder / "kept")
    assert run(*arguments).exit_code == 0
    refused = run(*arguments)
    assert isinstance(refused.exception, BadInput)
    assert "--force" in str(refused.exception)
    assert run(*arguments, "--force").exit_code == 0


@pytest.mark.parametrize(
    ("model", "message"),
    [
        ('{"schema": 99}', "schema up to 1 expected, 99 found; update this software"),
        ("[]", "is it a model"),
        ("{", "JSON written by `ident fit` expected"),
    ],
)
def test_invalid_model_files_are_explained(folder: Path, tmp_path: Path, model: str, message: str) -> None:
    path = tmp_path / "odd.model.json"
    path.write_text(model)
    result = run("compare", path, folder / "a.mcap", "--plots", tmp_path / "pictures")
    assert isinstance(result.exception, BadInput)
    assert message in str(result.exception)
    assert not (tmp_path / "pictures").exists()


def test_an_interruption_leaves_no_partial_folder(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("ident.output.plots.residuals.worst_windows", interrupted)
    before = sorted(folder.iterdir())
    result = run("compare", folder / "a.model.json", folder / "b.mcap", "--plots", folder / "half")
    assert result.exit_code == 1
    assert sorted(folder.iterdir()) == before
