"""`ident torque` as users call it."""

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

import ident
from ident.commands.torque import command
from recordings.recording import Recording
from tests.ident.kept_models import MODELS
from tests.running import printed

MODEL = str(MODELS / "stribeck.model.json")


run = partial(printed, command)


def test_the_table_of_a_trajectory_and_of_its_positions_agree(tmp_path: Path) -> None:
    options = ("--cycles", 1, "--rate", 200)
    document = json.loads(run(MODEL, "--traj", "fig5b", *options, "-o", tmp_path / "a.csv", "--json"))
    assert document["schema"] == 1
    assert {"inertia", "inertia_coupling", "coriolis", "gravity", "viscous", "coulomb"} < set(document["terms"])
    assert len(document["terms"]["stribeck"]["rms"]) == 3
    run(MODEL, "--csv", tmp_path / "a.csv", "-o", tmp_path / "b.table", "--to", "csv")
    assert (tmp_path / "a.csv").read_text() == (tmp_path / "b.table").read_text()
    assert "coriolis" in run(MODEL, "--traj", "fig5b", *options)


def test_the_rig_of_the_model_gives_its_rate(tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text('name = "mine"\nrate = 250\n')
    run(MODEL, "--traj", "fig5b", "--cycles", 1, "--rig", tmp_path / "rig.toml", "-o", tmp_path / "a.json")
    time = json.loads((tmp_path / "a.json").read_text())["columns"]["time"]
    np.testing.assert_allclose(np.diff(time), 1 / 250)


def test_the_picture_is_drawn_and_the_rms_has_intervals(
    make: Callable[..., Recording], write: Callable[[Recording], Path], tmp_path: Path
) -> None:
    model = tmp_path / "m.json"
    file = write(make(cycles=2, rate=250.0, noise=0.05, path=tmp_path / "a.mcap"))
    ident.fit([file], method="ls", without=["rod_inertia"]).save(model)
    document = json.loads(run(model, "--traj", "fig5b", "--cycles", 1, "--picture", tmp_path / "a.png", "--json"))
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    for name, term in document["terms"].items():
        for rms, (low, high) in zip(term["rms"], term["rms_ci95"], strict=True):
            assert 0 <= low < rms < high < 1.2 * rms, name
    assert "±" in run(model, "--traj", "fig5b", "--cycles", 1)
