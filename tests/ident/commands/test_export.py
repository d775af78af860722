"""`ident export` as users call it."""

import json
import shutil
from functools import partial
from pathlib import Path

import pytest

from ident.commands.export import command
from recordings.errors import BadInput
from tests.ident.export.models import model_with
from tests.ident.kept_models import MODELS
from tests.running import printed

MODEL = MODELS / "stateful.model.json"


run = partial(printed, command)


def test_every_target_says_what_is_lost_on_the_motion_of_the_fit(tmp_path: Path) -> None:
    model = tmp_path / "worn.model.json"
    shutil.copy(MODEL, model)
    shutil.copy(MODELS / "fig5a.mcap", tmp_path)
    for target, out, document in (
        ("c", "worn", "worn/carried.json"),
        ("mjcf", "worn.xml", "worn.xml.carried.json"),
        ("csv", "worn.csv", "worn.csv.carried.json"),
    ):
        printed = json.loads(run(model, "--to", target, "-o", tmp_path / out, "--json", "--force"))
        assert printed == json.loads((tmp_path / document).read_text())
        assert printed["motion"] == "fig5a.mcap"
        assert printed["target"] == target
        lost = [entry["effect"] for entry in printed["not_carried"]]
        assert lost == ([] if target == "csv" else ["joint_elasticity"])
        assert (max(printed["torque_lost_rms"]) > 0.01) == bool(lost)


def test_a_model_of_temperature_needs_one(tmp_path: Path) -> None:
    model_with(["temperature_friction"]).save(tmp_path / "m.json")
    arguments = (tmp_path / "m.json", "--to", "c", "--traj", "fig5b", "-o", tmp_path / "warm")
    with pytest.raises(BadInput, match="effect temperature_friction needs temperature"):
        run(*arguments)
    assert not (tmp_path / "warm").exists()
    run(*arguments, "--temperature", 30)
    assert "delta_model_temperature(&state" in (tmp_path / "warm" / "example.c").read_text()


def test_an_axis_is_exported_with_its_motion(tmp_path: Path) -> None:
    lines = [f"{k / 100},{0.01 * k * k}" for k in range(20)]
    (tmp_path / "path.csv").write_text("\n".join(["time,position_1", *lines]))
    run(MODELS / "slide.model.json", "--to", "c", "--csv", tmp_path / "path.csv", "-o", tmp_path / "slide")
    assert "#define DELTA_MODEL_DOF 1" in (tmp_path / "slide" / "delta_model.h").read_text()
