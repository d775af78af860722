"""The command as a user types it, on recordings written to disk."""

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from ident.data.prepared_recording import prepare
from ident.identification import model_file
from ident.identification.goodness_of_fit import goodness_of_fit
from ident.program import program
from recordings.reader import read
from recordings.recording import Floats, Recording
from tests.running import ran

BRIEF = ["--set", "iterations=150"]


@pytest.fixture(scope="module")
def recorded(
    make: Callable[..., Recording], write: Callable[[Recording], Path], tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """A folder with a.mcap and b.mcap."""
    folder = tmp_path_factory.mktemp("recorded")
    write(make("fig5a", cycles=1, noise=0.01, path=folder / "a.mcap"))
    write(make("fig5b", cycles=1, noise=0.01, path=folder / "b.mcap"))
    return folder


@pytest.fixture
def folder(recorded: Path, tmp_path: Path) -> Path:
    shutil.copytree(recorded, tmp_path, dirs_exist_ok=True)
    return tmp_path


fit = partial(ran, program, "fit")


def test_writes_model_and_pictures_and_prints_the_tables(folder: Path, truth: Floats) -> None:
    outputs = ["--details", "--pictures", folder / "pictures"]
    result = fit(folder / "a.mcap", "--validate", folder / "b.mcap", *BRIEF, *outputs, "--without", "rod_inertia")
    for text in ("SIMULATED", "RELATIVE", "L2 = 0.8 m is assumed", "m_p", "Eq. (41)", "validation", "held out"):
        assert text in result.stdout
    content = json.loads((folder / "a.model.json").read_text())
    np.testing.assert_allclose([parameter["value"] for parameter in content["parameters"]], truth, rtol=0.01)
    assert min(content["validate"]["fitted"]["nrmse"]) > 0.99 > max(content["validate"]["nominal"]["nrmse"])
    pictures = sorted(path.name for path in (folder / "pictures").iterdir())
    assert pictures == [
        "convergence.png",
        "train_1_torque.png",
        "validate_1_torque.png",
    ]


def test_ten_lines_lead_on(folder: Path) -> None:
    before = set(folder.iterdir())
    result = fit(folder / "a.mcap", "--validate", folder / "b.mcap", *BRIEF)
    assert len(result.stdout.splitlines()) <= 10
    assert set(folder.iterdir()) - before == {folder / "a.model.json"}, "nothing else unless it is asked for"
    for text in ("SIMULATED", "RELATIVE", "rod_inertia", "training", "held out", "%"):
        assert text in result.stdout
    assert result.stderr.splitlines()[-1].startswith("next: ident ")
    assert json.loads((folder / "a.model.json").read_text())["effects"] == ["rod_inertia"]


def test_every_pso_result_is_certified(folder: Path) -> None:
    result = fit(folder / "a.mcap", "--details", "--without", "rod_inertia")
    assert "above its certified minimum" in " ".join(result.stdout.split())
    method = json.loads((folder / "a.model.json").read_text())["method"]
    assert method["certified"]["lower_bound"] <= method["certified"]["minimum"] <= method["objective"]
    assert 0 <= method["certified"]["excess"] <= 1e-8 == method["settings"]["tolerance"]
    assert method["diagnostics"]["iterations"] < 1000


def test_a_swarm_that_ends_above_the_minimum_says_so(folder: Path) -> None:
    printed = " ".join(fit(folder / "a.mcap", "--set", "iterations=2").stdout.split())
    assert (
        "times the certified minimum, so these are not the parameters of the best fit: choose --method lad" in printed
    )


def test_the_papers_procedure_takes_all_rows_and_all_iterations(folder: Path) -> None:
    fit(folder / "a.mcap", "--paper")
    content = json.loads((folder / "a.model.json").read_text())
    assert content["preprocessing"]["name"] == "central"
    assert content["effects"] == []
    assert content["preprocessing"]["rate"] == 500
    assert content["method"]["settings"]["tolerance"] == 0
    assert content["method"]["diagnostics"]["iterations"] == 1000
    assert content["method"]["certified"]["excess"] < 1e-6
    fit(folder / "a.mcap", "--paper", "--set", "iterations=5", "--force")  # for a trial
    assert json.loads((folder / "a.model.json").read_text())["method"]["diagnostics"]["iterations"] == 5


@pytest.mark.parametrize("method", ["rls", "svd"])
def test_a_baseline_writes_the_model_form_that_it_identified(folder: Path, method: str) -> None:
    result = fit(folder / "a.mcap", "--validate", folder / "b.mcap", "--method", method, "--details")
    assert "Eq. (38)" in result.stdout
    assert ("Rank 13 of 14" in result.stdout) == (method == "svd")
    loaded = model_file.load(folder / "a.model.json")
    assert loaded.form == "lagrange14"
    assert [parameter.name for parameter in loaded.parameters] == [f"theta_{i}" for i in range(1, 15)]
    prepared = prepare(read(folder / "b.mcap"), "parallel", None, form=loaded.form)
    predicted = prepared.regressor @ np.array([parameter.value for parameter in loaded.parameters])
    assert goodness_of_fit(prepared.torque, predicted).rms == pytest.approx(loaded.validate_.fitted.rms)


def test_the_same_seed_gives_the_same_bytes(folder: Path) -> None:
    out = [folder / f"{i}.json" for i in range(3)]
    for path, seed in zip(out, (5, 5, 6), strict=True):
        fit(folder / "a.mcap", *BRIEF, "--seed", seed, "-o", path)
    assert out[0].read_bytes() == out[1].read_bytes() != out[2].read_bytes()


def test_settings_are_kept_in_the_model_and_json_is_one_document(folder: Path) -> None:
    model = folder / "a.model.json"
    fit(folder / "a.mcap", *BRIEF, "--set", "N_p=40", "--set", "neighbours=8")
    kept = json.loads(model.read_text())["method"]["settings"]
    again = fit(folder / "a.mcap", folder / "b.mcap", *BRIEF, "--json", "--force")
    document = json.loads(again.stdout)
    assert [source["name"] for source in document["train"]["recordings"]] == ["a.mcap", "b.mcap"]
    assert document["schema"] == 2
    assert document["where"]
    assert (kept["particles"], kept["neighbours"], kept["iterations"]) == (40, 8, 150)


@pytest.mark.parametrize("arguments", [["--help"], ["fit", "--help"]])
def test_help_is_instant(arguments: list[str]) -> None:
    """Help must not import the libraries of a fit."""
    code = (
        f"import sys; from ident.program import program; program({arguments!r}, standalone_mode=False); "
        "print([name for name in ('numpy', 'scipy', 'numba', 'matplotlib', 'pydantic') if name in sys.modules])"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert shown.stdout.splitlines()[-1] == "[]"
    assert "Example: ident fit" in shown.stdout
