"""`ident torque` as users call it."""

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import ident
from ident.commands.torque import command
from recordings.errors import BadInput
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


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "one of --traj, --csv and a recording expected"),
        (("--traj", "fig5b", MODELS / "fig5b.mcap"), "one of --traj, --csv and a recording expected"),
        (("--traj", "fig5c"), "unknown trajectory 'fig5c'"),
        (("--csv", "nothing.csv"), "nothing.csv does not exist"),
        ((MODELS / "fig5b.mcap", "--cycles", 2), "--cycles and --rate belong to --traj"),
        ((MODELS / "fig5b.mcap", "--temperature", 20), "--temperature belongs to a path that is given"),
        (("--traj", "fig5b", "-o", "a.xlsx"), "an ending of .csv"),
        (("--traj", "fig5b", "-o", "a.csv", "--to", "xlsx"), "one of csv, json, parquet expected, 'xlsx' found"),
    ],
)
def test_wrong_input_is_refused(
    arguments: tuple[object, ...], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BadInput, match=message):
        run(MODEL, *arguments)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('name = "other"\n[geometry]\nL2 = 0.81\n', "geometry.L2 is 0.8 in the model, 0.81 in"),
        ('name = "other"\n[torque]\ngain = [1.0, 1.0, 1.1]\n', "torque.gain is"),
        ('name = "other"\nmechanism = "axes"\n[[axes]]\n[[axes]]\n[[axes]]\n', "mechanism is delta in the model"),
    ],
)
def test_another_rig_is_refused(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text(text)
    with pytest.raises(BadInput, match=message):
        run(MODEL, "--traj", "fig5b", "--rig", tmp_path / "rig.toml")


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
