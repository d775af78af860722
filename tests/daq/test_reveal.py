"""`daq reveal`: the truth beside what was found."""

import json
import re
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from daq.commands.reveal import command
from drivers.simulated.config import SimConfig
from drivers.simulated.effect import discover
from drivers.simulated.effect import library as simulated_library
from drivers.simulated.seal import seal
from ident.dynamics.effects.library import library
from recordings.errors import BadInput
from tests.running import invoke

PLANT = SimConfig().model_dump(mode="json", exclude={"effects"})
COGGING = {
    "name": "cogging",
    "joints": [1, 2],
    "parameters": {"N": 14.0, "a": 0.5, "phase": 0.0},
    "in_library": True,
    "size": 0.04,
    "depends_on": ["position"],
}


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    """The name of a recording beside which the truth is sealed."""
    seal(tmp_path / "a.sealed.json", {"schema": 1, "seed": 9, "effects": [COGGING], "plant": PLANT})
    return tmp_path / "a.mcap"


reveal = partial(invoke, command)


def diagnosis(path: Path, effect: str, joints: list[int], alternatives: list[str] | None = None) -> Path:
    values = {"m_p": 2.1, f"{effect}.a1": 0.51, f"{effect}.b1": 0.0, "rod_inertia.m_d": 0.4}
    findings: list[dict[str, Any]] = [
        {"effect": "rod_inertia", "joints": [1, 2, 3], "confusable_with": []},
        {"effect": effect, "joints": joints, "confusable_with": alternatives or []},
    ]
    intervals = {f"{effect}.a1": {"ci95": [0.3, 0.7], "shape_ci95": [0.49, 0.53]}, "m_p": {"ci95": [2.0, 2.2]}}
    steps = [{"parameters": {name: {"value": value} | intervals.get(name, {}) for name, value in values.items()}}]
    path.write_text(json.dumps({"findings": findings, "steps": steps}))
    return path


def test_the_truth_alone(recording: Path) -> None:
    for file in (recording, recording.with_suffix(".sealed.json")):
        result = reveal(file)
        assert result.exit_code == 0, result.output
        assert result.stdout == "hidden: cogging on joint 1, 2 (N = 14, a = 0.5, b = 0)\n"
        assert result.stderr == f"next: ident diagnose {recording} --apply\n"


def test_truth_beside_what_was_found(recording: Path) -> None:
    model = diagnosis(recording.with_name("d.json"), "cogging", [1, 2])
    result = reveal(recording, model)
    assert "hidden: cogging on joint 1, 2 (N = 14, a = 0.5, b = 0): found\n" in result.stdout
    assert re.search(r"^  cogging.a1 +true +0.5  found +0.51  95 %: 0.49 to 0.53$", result.stdout, re.MULTILINE)
    assert re.search(r"^  cogging.b1 +true +0  found +0  no interval$", result.stdout, re.MULTILINE)
    assert "not hidden" not in result.stdout
    document = json.loads(reveal(recording, model, "--json").stdout)
    assert document["parameters"]["cogging.a1"] == {"true": 0.5, "found": 0.51, "ci95": [0.49, 0.53]}
    assert document["parameters"]["m_p"]["found"] == 2.1
    assert document["found"] == [{"effect": "cogging", "joints": [1, 2]}]


@pytest.mark.parametrize(
    ("effect", "joints", "alternatives", "verdict"),
    [
        ("cogging", [3], [], "found on joint 3"),
        ("stribeck", [1, 2], [], "not found"),
        ("stribeck", [1, 2], ["cogging"], "found as stribeck, from which these recordings cannot tell it"),
    ],
)
def test_verdicts(recording: Path, effect: str, joints: list[int], alternatives: list[str], verdict: str) -> None:
    model = diagnosis(recording.with_name("d.json"), effect, joints, alternatives)
    result = reveal(recording, model)
    assert result.stdout.splitlines()[0].endswith(f": {verdict}")
    assert ("found, but not hidden: stribeck" in result.stdout) == (effect == "stribeck")


NOT_KNOWN = "not in this model; whether another effect stands for it, the output of `ident diagnose --json` says"


@pytest.mark.parametrize(
    ("terms", "verdict"),
    [(["cogging"], "found"), (["rod_inertia"], "not found"), (["rod_inertia", "stribeck"], NOT_KNOWN)],
)
def test_a_model_takes_the_place_of_a_diagnosis(recording: Path, terms: list[str], verdict: str) -> None:
    model = recording.with_name("m.json")
    entries = {"parameters": [{"name": "m_p", "value": 2.0}], "searched": [{"name": "cogging.N", "value": 14.01}]}
    model.write_text(json.dumps({**entries, "terms": [{"name": name, "joints": [1, 2]} for name in terms]}))
    document = json.loads(reveal(recording, model, "--json").stdout)
    assert document["hidden"][0]["verdict"] == verdict
    assert document["parameters"]["cogging.N"] == {"true": 14.0, "found": 14.01, "ci95": None}


def test_a_hidden_effect_has_the_parameters_of_a_diagnosis(tmp_path: Path) -> None:
    spring = {"name": "joint_spring", "joints": [1, 3], "parameters": {"k": 2.0, "q_0": 0.3}, "in_library": True}
    seal(tmp_path / "a.sealed.json", {"schema": 1, "seed": None, "effects": [spring], "plant": PLANT})
    model = tmp_path / "m.json"
    values = {f"joint_spring.{name}{joint}": float(joint) for joint in (1, 3) for name in ("k", "a")}
    parameters = [{"name": name, "value": value, "ci95": [0.0, 4.0]} for name, value in values.items()]
    model.write_text(json.dumps({"parameters": parameters, "terms": [{"name": "joint_spring", "joints": [1, 3]}]}))
    result = reveal(tmp_path / "a.mcap", model)
    assert result.stdout.startswith("hidden: joint_spring on joint 1, 3 (k = 2, a = -0.6): found\n")
    shown = json.loads(reveal(tmp_path / "a.mcap", model, "--json").stdout)["parameters"]
    assert {name: entry["true"] for name, entry in shown.items()} == {
        name: 2.0 if ".k" in name else -0.6 for name in values
    }


def test_the_truth_of_another_plant_is_shown_as_it_is(tmp_path: Path) -> None:
    fan = {"name": "fan", "joints": [2], "parameters": {"a": 0.4, "f": 12.0}, "in_library": False}
    seal(tmp_path / "a.sealed.json", {"schema": 1, "seed": 1, "effects": [fan, COGGING]})
    model = diagnosis(tmp_path / "d.json", "cogging", [1, 2])
    shown = reveal(tmp_path / "a.mcap", model).stdout
    assert shown.startswith("hidden: fan on joint 2 (a = 0.4, f = 12): not found: no effect of the library\n")
    assert "cogging.a1" in shown


NOT_OF_THE_MACHINE = {
    "self_heating.k": "depends on the power in the recordings",
    "payload_change.t_r": "only smooths the change",
    "joint_elasticity.motor": "a share that the fit chooses",
    "joint_elasticity.damping": "of the spring's own law",
    "backlash.motor": "a share that the fit chooses",
}


@pytest.mark.parametrize("name", simulated_library())
def test_every_effect_is_described_by_the_parameters_of_the_library(name: str) -> None:
    effect = library()[name]
    named = [quantity.name for quantity in (*effect.parameters, *effect.shapes)]
    found = {f"{each}1": 0.1 for each in named} | {"low1": -0.5, "high1": 0.5}
    given = discover()[name]().identified(1, 0.5, found)
    assert {*given} <= {*named}
    left = {f"{name}.{each}" for each in {*named} - {*given} - {"low", "high"}}
    assert left <= NOT_OF_THE_MACHINE.keys()


@pytest.mark.parametrize("content", ["", "[]", "{}", '{"findings": 3}', "\xff"])
def test_what_is_no_diagnosis_is_refused(recording: Path, content: str) -> None:
    wrong = recording.with_name("wrong.json")
    wrong.write_bytes(content.encode("latin-1"))
    result = reveal(recording, wrong)
    assert isinstance(result.exception, BadInput)
    assert "wrong.json" in str(result.exception)
    missing = reveal(recording.with_name("none.mcap")), reveal(recording, recording.with_name("none.json"))
    assert all("does not exist" in str(each.exception) for each in missing)
