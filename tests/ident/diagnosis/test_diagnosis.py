"""What is hidden in a plant that shares nothing with the identifier is found, named, and nothing else."""

import json
import shlex
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

from ident.cli import program
from recordings.errors import BadInput
from tests.foreign.pairs import TRAIN, VALIDATE, Setting, make

pytestmark = pytest.mark.slow
Hide = Callable[..., Path]


@pytest.fixture(scope="module")
def hide(tmp_path_factory: pytest.TempPathFactory) -> Hide:
    made: dict[Any, Path] = {}

    def folder(effects: Sequence[str], size: float = 0.03, seed: int = 1, robot: str = "default") -> Path:
        key = (*effects, size, seed, robot)
        if key not in made:
            made[key] = tmp_path_factory.mktemp("hidden")
            make(made[key], effects, [size] * len(effects), seed, Setting(robot=robot))  # type: ignore[arg-type]
        return made[key]

    return folder


def run(*arguments: object) -> Result:
    return CliRunner().invoke(program, [*map(str, arguments)], catch_exceptions=True)


def diagnose(folder: Path, *options: object, validate: bool = True) -> dict[str, Any]:
    held_out = ["--validate", folder / VALIDATE] if validate else []
    result = run("diagnose", folder / TRAIN, *held_out, "--json", "--force", *options)
    assert result.exit_code == 0, result.output
    found: dict[str, Any] = json.loads(result.stdout)
    return found


def news(found: dict[str, Any]) -> list[str]:
    return [one["effect"] for one in found["findings"] if one["effect"] != "rod_inertia"]


@pytest.mark.parametrize("robot", ["default", "light", "heavy"])
def test_nothing_hidden_is_adequate(hide: Hide, robot: str) -> None:
    found = diagnose(hide([], robot=robot))
    assert found["verdict"] == "adequate"
    assert news(found) == []
    last = found["rungs"][-1]
    assert (np.array(last["validate_rms"]) < 1.15 * np.array(found["noise_rms"])).all()


@pytest.mark.parametrize(
    "effect",
    [
        "quadratic_friction",
        "presliding_hysteresis",
        "cogging",
        "base_tilt",
        "actuation_delay",
        "geometry_error",
        "torque_gain_mismatch",
        "encoder_zero_offset",
    ],
)
def test_the_hidden_effect_is_named_first(hide: Hide, effect: str) -> None:
    found = diagnose(hide([effect]))
    assert found["verdict"] == "missing-effect"
    first = next(one for one in found["findings"] if one["effect"] != "rod_inertia")
    assert effect == first["effect"] or effect in first["confusable_with"]
    assert len(first["confusable_with"]) <= 4
    assert first["gain_ci95"][0] <= first["gain"] <= first["gain_ci95"][1]
    before, after = (np.array(found["rungs"][i]["validate_rms"]) for i in (0, -1))
    assert (after < before).all()


def test_friction_that_differs_by_direction_is_no_offset(hide: Hide) -> None:
    assert news(diagnose(hide(["asymmetric_viscous"]))) == ["asymmetric_viscous"]


def test_friction_that_rises_concavely_is_not_called_stribeck(hide: Hide) -> None:
    found = diagnose(hide(["concave_friction"]))
    assert "stribeck" not in news(found)
    assert "stribeck" not in {name for one in found["findings"] for name in one["confusable_with"]}
    assert found["verdict"] == "unknown-structure"
    assert "velocity" in found["remaining"]["depends_on"]


def test_two_effects_are_both_found(hide: Hide) -> None:
    found = diagnose(hide(["cogging", "quadratic_friction"]))
    assert {"cogging", "quadratic_friction"} <= set(news(found))
    assert len(news(found)) <= 3


def test_what_is_in_no_library_is_said_to_be_unknown_and_drawn(hide: Hide, tmp_path: Path) -> None:
    folder, plots = hide(["fan"]), tmp_path / "plots"
    found = diagnose(folder, "--plots", plots)
    assert found["verdict"] == "unknown-structure"
    assert "frequency" in found["remaining"]["depends_on"]
    assert {"remains.png", "remains_spectrum.png"} <= {path.name for path in plots.iterdir()}


def test_a_learned_curve_stands_in_for_what_nobody_knows(hide: Hide, tmp_path: Path) -> None:
    folder, curve = hide(["uneven_grease"]), tmp_path / "curve.py"
    found = diagnose(folder, "--stand-in", curve, "--plots", tmp_path / "plots")
    before, stand_in = found["rungs"][-1]["validate_rms"], found["stand_in"]
    joints = stand_in["joints"]
    assert all(stand_in["validate_rms"][joint - 1] < 0.5 * before[joint - 1] for joint in joints)
    assert found["remaining"]["depends_on"] == ["position", "velocity"]
    assert {"remains.png", "remains_curves.png"} <= {path.name for path in (tmp_path / "plots").iterdir()}
    assert not (tmp_path / "plots" / "remains_spectrum.png").exists()
    assert stand_in["gain_ci95"][0] > 0.5
    with_it = (
        "--with",
        "rod_inertia",
        "--with",
        f"curve:{','.join(map(str, joints))}",
        "--effect-file",
        curve,
        "--method",
        "ls",
    )
    model = tmp_path / "m.json"
    fitted = run(
        "fit", folder / TRAIN, "--validate", folder / VALIDATE, *with_it, "-o", model, "--plots", tmp_path / "p"
    )
    assert fitted.exit_code == 0, fitted.output
    shares = [one for one in json.loads(model.read_text())["parameters"] if one["name"].startswith("curve.a")]
    assert [share["value"] for share in shares] == pytest.approx([1.0] * len(joints), abs=0.1)


def test_no_curve_is_learned_from_noise(hide: Hide, tmp_path: Path) -> None:
    curve = tmp_path / "curve.py"
    found = diagnose(hide([]), "--stand-in", curve, "--plots", tmp_path / "plots")
    assert found["stand_in"] is None
    assert not curve.exists()


def test_the_document_is_the_agreed_one(hide: Hide) -> None:
    found = diagnose(hide(["cogging"]))
    assert found["schema"] == 1
    assert {
        "verdict",
        "bandwidth_hz",
        "noise_rms",
        "rungs",
        "findings",
        "rejected",
        "remaining",
        "next_motion",
    } <= set(found)
    assert found["rungs"][0]["added"] is None
    for rung in found["rungs"]:
        assert {"added", "effects", "train_rms", "validate_rms", "parameters"} <= set(rung)
        for value in rung["parameters"].values():
            assert {"value", "unit", "ci95"} <= set(value)
    assert {one["status"] for one in found["rejected"]} <= {
        "not-supported",
        "not-tested",
        "not-observable",
        "absorbed",
    }
    named = {one["effect"] for one in found["findings"]} | {one["effect"] for one in found["rejected"]}
    from ident.dynamics.effects.library import names

    assert named == set(names())
    assert {"effect": "amplifier_deadband", "status": "not-observable"}.items() <= next(
        one for one in found["rejected"] if one["effect"] == "amplifier_deadband"
    ).items()


def test_without_another_recording_phase_segments_are_held_out(hide: Hide) -> None:
    found = diagnose(hide(["cogging"]), validate=False)
    assert "phase segments" in found["held_out"]
    assert news(found) == ["cogging"]
    assert found["next_motion"]["command"].startswith("ident design")


def test_the_recommended_motion_can_be_designed(hide: Hide, tmp_path: Path) -> None:
    found = diagnose(hide(["arm_mass_mismatch"], size=0.01), validate=False)
    (named,) = (one for one in found["findings"] if one["effect"] != "rod_inertia")
    assert named["confusable_with"]
    command = shlex.split(found["next_motion"]["command"])
    assert command[0] == "ident"
    assert command[-2:] == ["-o", "next.toml"]
    result = run(*command[1:-1], tmp_path / "next.toml", "--json", "--harmonics", 1)
    assert result.exit_code == 0, result.output
    designed = json.loads(result.stdout)
    assert set(designed["after"]["told_apart"]) == {named["effect"], *named["confusable_with"]}
    assert (tmp_path / "next.toml").exists()


def test_the_improved_model_explains_as_much_in_a_file(hide: Hide, tmp_path: Path) -> None:
    folder = hide(["presliding_hysteresis"])
    model = tmp_path / "better.model.json"
    found = diagnose(folder, "--apply", "-o", model)
    compared = run("compare", model, folder / VALIDATE, "--json", "--plots", tmp_path / "plots")
    rms = [joint["rms"] for joint in json.loads(compared.stdout)["joints"]]
    # Comparing looks at standstill, too, which a diagnosis leaves out.
    np.testing.assert_allclose(rms, found["rungs"][-1]["validate_rms"], rtol=0.3)
    again = run("diagnose", folder / TRAIN, "--validate", folder / VALIDATE, "--model", model, "--json", "--force")
    document = json.loads(again.stdout)
    assert document["rungs"][0]["effects"] == ["rod_inertia", "presliding_hysteresis"]
    assert document["verdict"] == "adequate"
    assert all(finding["in_model"] for finding in document["findings"])


def test_pictures_are_drawn_and_words_are_said(hide: Hide, tmp_path: Path) -> None:
    folder = hide(["cogging"])
    shown = run("diagnose", folder / TRAIN, "--validate", folder / VALIDATE, "--plots", tmp_path / "d")
    assert "missing-effect" in shown.stdout
    assert "Usual causes" in shown.stdout
    assert {path.name for path in (tmp_path / "d").iterdir()} >= {"ladder.png", "finding_1_rod_inertia.png"}


@pytest.mark.parametrize(
    ("options", "found"),
    [
        (["--out", "m.json"], "--apply expected"),
        (["--model", "none.json"], "does not exist"),
        (["--effect-file", "none.py"], "Python file"),
    ],
)
def test_bad_input_is_refused(hide: Hide, options: list[str], found: str) -> None:
    result = run("diagnose", hide(["cogging"]) / TRAIN, "--force", *options)
    assert isinstance(result.exception, BadInput)
    assert found in str(result.exception)
