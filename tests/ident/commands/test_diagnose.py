"""`ident diagnose` finds and names the hidden effects of an independently written simulator, and nothing else."""

import json
import re
import shlex
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.document.document import Document
from ident.dynamics.effects.library import names
from ident.program import program
from tests.foreign.pairs import TRAIN, VALIDATE, Setting, make
from tests.running import ran

pytestmark = pytest.mark.slow
Hide = Callable[..., Path]


@pytest.fixture(scope="module")
def hide(tmp_path_factory: pytest.TempPathFactory) -> Hide:
    folders: dict[Any, Path] = {}

    def folder(effects: Sequence[str], size: float = 0.03, seed: int = 1, robot: str = "default") -> Path:
        key = (*effects, size, seed, robot)
        if key not in folders:
            folders[key] = tmp_path_factory.mktemp("hidden")
            make(folders[key], effects, [size] * len(effects), seed, Setting(robot=robot))  # type: ignore[arg-type]
        return folders[key]

    return folder


run = partial(ran, program)


def diagnose(folder: Path, *options: object, validate: bool = True) -> dict[str, Any]:
    held_out = ["--validate", folder / VALIDATE] if validate else []
    result = run("diagnose", folder / TRAIN, *held_out, "--json", "--force", *options)
    document: dict[str, Any] = json.loads(result.stdout)
    return document


def new_effects(document: dict[str, Any]) -> list[str]:
    return [finding["effect"] for finding in document["findings"] if finding["effect"] != "rod_inertia"]


@pytest.mark.parametrize("robot", ["default", "light", "heavy"])
def test_model_without_hidden_effect_is_adequate(hide: Hide, robot: str, tmp_path: Path) -> None:
    curve = tmp_path / "curve.py"
    document = diagnose(hide([], robot=robot), "--learn", curve)
    assert document["verdict"] == "adequate"
    assert new_effects(document) == []
    last = document["steps"][-1]
    assert (np.array(last["held_out_rms"]) < 1.15 * np.array(document["noise_rms"])).all()
    assert not document["learned_curve"], "no curve is learned from noise"
    assert not curve.exists()


@pytest.mark.parametrize(
    "effect", ["presliding_hysteresis", "actuation_delay", "geometry_error", "encoder_zero_offset"]
)
def test_hidden_effect_is_named_first(hide: Hide, effect: str) -> None:
    document = diagnose(hide([effect]))
    assert document["verdict"] == "missing-effect"
    first = next(finding for finding in document["findings"] if finding["effect"] != "rod_inertia")
    assert effect == first["effect"] or effect in first["confusable_with"]
    assert len(first["confusable_with"]) <= 4
    assert first["evidence"]["gain_ci95"][0] <= first["evidence"]["gain"] <= first["evidence"]["gain_ci95"][1]
    before, after = (np.array(document["steps"][i]["held_out_rms"]) for i in (0, -1))
    assert (after < before).all()


@pytest.mark.parametrize("hidden", [("asymmetric_viscous",), ("cogging", "quadratic_friction")])
def test_nothing_but_what_is_hidden_is_found(hide: Hide, hidden: tuple[str, ...]) -> None:
    found = new_effects(diagnose(hide(hidden)))
    assert set(hidden) <= set(found)
    assert len(found) <= 2 * len(hidden) - 1, "asymmetric friction is no offset"


def test_concave_friction_is_not_stribeck(hide: Hide) -> None:
    folder = hide(["power_law_friction"])
    assert new_effects(diagnose(folder)) == ["power_law_friction"]
    document = diagnose(folder, "--without", "power_law_friction")
    assert "stribeck" not in new_effects(document)
    assert "stribeck" not in {name for finding in document["findings"] for name in finding["confusable_with"]}
    assert document["verdict"] == "unknown-structure"
    assert "velocity" in document["remaining"]["depends_on"]


def figures(page: Path) -> set[str]:
    """Names of the figures on a page."""
    return set(re.findall(r'data-figure="plot-([a-z0-9-]+)"', page.read_text(encoding="utf-8")))


def test_effect_outside_the_library_is_unknown_and_drawn(hide: Hide, tmp_path: Path) -> None:
    folder, page = hide(["fan"]), tmp_path / "page.html"
    document = diagnose(folder, "--report", page)
    assert document["verdict"] == "unknown-structure"
    assert "frequency" in document["remaining"]["depends_on"]
    assert {"unexplained-curves", "unexplained-spectrum"} <= figures(page)


def test_learned_curve_replaces_an_unknown_effect(hide: Hide, tmp_path: Path) -> None:
    folder, curve = hide(["uneven_grease"], seed=2), tmp_path / "curve.py"
    document = diagnose(folder, "--learn", curve, "--report", tmp_path / "page.html")
    before, learned_curve = document["steps"][-1]["held_out_rms"], document["learned_curve"]
    joints = learned_curve["joints"]
    assert all(learned_curve["held_out_rms"][joint - 1] < 0.5 * before[joint - 1] for joint in joints)
    assert document["remaining"]["depends_on"] == ["position", "velocity"]
    assert {"unexplained-curves", "learned"} <= figures(tmp_path / "page.html")
    assert "unexplained-spectrum" not in figures(tmp_path / "page.html")
    assert learned_curve["gain_ci95"][0] > 0.5
    effects = ("--with", "rod_inertia", "--with", f"curve:{','.join(map(str, joints))}", "--effect-file", curve)
    model = tmp_path / "m.json"
    run("fit", folder / TRAIN, "--validate", folder / VALIDATE, *effects, "--method", "ls", "-o", model)
    scales = [entry for entry in json.loads(model.read_text())["parameters"] if entry["name"].startswith("curve.a")]
    assert [scale["value"] for scale in scales] == pytest.approx([1.0] * len(joints), abs=0.1)


def test_document_names_every_effect_of_the_library(hide: Hide) -> None:
    document = diagnose(hide(["cogging"]))
    assert Document.model_validate_json(json.dumps(document)).as_json() == document
    assert document["steps"][0]["added"] is None
    named = {entry["effect"]: entry["status"] for entry in (*document["findings"], *document["rejected"])}
    assert set(named) == set(names())
    assert named["amplifier_deadband"] == "not-observable"


def test_the_recommended_motion_can_be_designed(hide: Hide, tmp_path: Path) -> None:
    document = diagnose(hide(["arm_mass_mismatch"], size=0.01), validate=False)
    (finding,) = (finding for finding in document["findings"] if finding["effect"] != "rod_inertia")
    assert finding["confusable_with"]
    command = shlex.split(document["next_motion"]["command"])
    assert command[0] == "ident"
    assert command[-2:] == ["-o", "next.toml"]
    result = run(*command[1:-1], tmp_path / "next.toml", "--json", "--harmonics", 1)
    designed = json.loads(result.stdout)
    assert set(designed["after"]["discrimination"]) == {finding["effect"], *finding["confusable_with"]}
    assert (tmp_path / "next.toml").exists()


def test_applied_model_predicts_as_well_from_its_file(hide: Hide, tmp_path: Path) -> None:
    folder = hide(["presliding_hysteresis"])
    model = tmp_path / "better.model.json"
    document = diagnose(folder, "--apply", "-o", model)
    compared = run("compare", model, folder / VALIDATE, "--json")
    rms = [joint["rms"] for joint in json.loads(compared.stdout)["joints"]]
    np.testing.assert_allclose(rms, document["steps"][-1]["held_out_rms"], rtol=1e-9)
    values = {entry["name"]: entry["value"] for entry in json.loads(model.read_text())["parameters"]}
    shown = document["steps"][-1]["parameters"]
    assert values == {name: shown[name]["value"] for name in values}
    again = run("diagnose", folder / TRAIN, "--validate", folder / VALIDATE, "--model", model, "--json", "--force")
    extended = json.loads(again.stdout)
    assert extended["steps"][0]["effects"] == ["rod_inertia", "presliding_hysteresis"]
    assert extended["verdict"] == "adequate"
    assert all(finding["in_model"] for finding in extended["findings"])


def test_tables_and_page_are_written(hide: Hide, tmp_path: Path) -> None:
    folder, page = hide(["cogging"]), tmp_path / "d.html"
    options = ("--only", "cogging", "--report", page)
    shown = run("diagnose", folder / TRAIN, "--validate", folder / VALIDATE, *options)
    assert shown.stderr.splitlines()[-1].startswith("next: ident diagnose")
    assert "missing-effect" in shown.stdout
    assert "Usual causes" in shown.stdout
    assert figures(page) >= {"steps", "finding-1", "finding-2", "unexplained"}
    command = f"ident diagnose {TRAIN} --validate {VALIDATE} --only cogging --json"
    assert command in page.read_text(encoding="utf-8"), "how to reproduce it"
