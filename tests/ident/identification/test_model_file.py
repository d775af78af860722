"""Model files, and the agreement and effects that stand in them."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ident.dynamics.effects.library import library
from ident.identification import model_file
from ident.identification.chosen_effects import parse_terms
from ident.identification.goodness_of_fit import goodness_of_fit
from ident.identification.model_file import ModelFile
from recordings.errors import BadInput
from recordings.rig import Axis, Rig
from tests.ident import building

AGREEMENT: dict[str, Any] = {
    "recordings": [{"name": "a.mcap", "sha256": "00", "simulated": True}],
    "fitted": {"nrmse": [0.9, 0.9, 0.9], "rms": [0.1, 0.1, 0.1], "r2": [0.9, 0.9, 0.9]},
    "nominal": {"nrmse": [0.8, 0.8, 0.8], "rms": [0.2, 0.2, 0.2], "r2": [0.5, 0.5, 0.5]},
}
CONTENT: dict[str, Any] = {
    "schema": 2,
    "software": "0.1.0",
    "mechanism": "delta",
    "joints": ["joint_1", "joint_2", "joint_3"],
    "geometry": {},
    "torque": {},
    "relative": True,
    "parameters": [
        {"name": "m_p", "value": 1, "unit": "kg", "lower": 0, "upper": 9, "at_bound": False, "paper_value": 1}
    ],
    "method": {"name": "pso", "settings": {"particles": 300}, "seed": 0, "objective": 1.5, "rows": 100},
    "preprocessing": {"name": "parallel", "bandwidth": 30, "rate": 125},
    "train": AGREEMENT,
    "validate": AGREEMENT,
}


def written(path: Path, **changes: Any) -> Path:
    path.write_text(json.dumps({**CONTENT, **changes}))
    return path


def test_a_saved_model_is_loaded_unchanged(tmp_path: Path) -> None:
    loaded = model_file.load(written(tmp_path / "a.json"))
    assert loaded.validate_ is not None
    model_file.save(loaded, tmp_path / "b.json")
    assert model_file.load(tmp_path / "b.json") == loaded
    model_file.save(loaded, tmp_path / "c.json")
    assert (tmp_path / "b.json").read_bytes() == (tmp_path / "c.json").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.json", "b.json", "c.json"]
    assert model_file.load(written(tmp_path / "a.json", validate=None)).validate_ is None


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"schema": 3}, "schema 2 expected, 3 found; update"),
        ({"schema": 1}, "schema 2 expected, 1 found; fit the recordings again"),
        ({"schema": None}, "is it a model"),
        ({"mechanism": "octopod"}, "mechanism"),
        ({"parameters": [{"name": "m_p"}]}, "parameters"),
        ({"surprise": 1}, "unknown key 'surprise'"),
        ({"geometry": None}, "the geometry of a delta robot"),
        ({"joints": ["a", "b"]}, "joints: those of the mechanism"),
        ({"torque": {"gain": [1, 2]}}, "torque.gain: a value for each of 3 joints expected, 2 found"),
        (
            {"train": AGREEMENT | {"nominal": None, "fitted": AGREEMENT["fitted"] | {"r2": [1]}}},
            "r2: a value for each",
        ),
        (
            {"effects": ["cogging"], "terms": [{"name": "cogging", "joints": [4]}]},
            "different joints",
        ),
    ],
)
def test_an_invalid_model_is_refused(tmp_path: Path, changes: dict[str, Any], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        model_file.load(written(tmp_path / "a.json", **changes))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"\x89MCAP0\r\n", "cannot be read: it is no text"),
        *((content, r"a\.json") for content in (b"", b"\xff\xfe", b"{", b"[1]", b"89")),
        (None, "does not exist"),
    ],
)
def test_a_file_that_is_not_a_model_is_refused(tmp_path: Path, content: bytes | None, message: str) -> None:
    path = tmp_path / "a.json"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(BadInput, match=message):
        model_file.load(path)


def test_a_model_contains_the_software_version_and_the_schema() -> None:
    content = {key: value for key, value in CONTENT.items() if key not in ("software", "schema")}
    signed = ModelFile.model_validate_json(json.dumps(content))
    assert signed.as_json()["schema"] == model_file.SCHEMA
    assert signed.software


def test_is_eq_41_with_the_range_of_the_models_torque() -> None:
    measured = np.array([[0.0], [1.0], [2.0], [3.0]])
    computed = np.array([[0.5], [1.5], [2.5], [4.5]])
    fit = goodness_of_fit(measured, computed)
    rms = np.sqrt((3 * 0.5**2 + 1.5**2) / 4)
    assert fit.rms == pytest.approx((rms,))
    assert fit.nrmse == pytest.approx((1 - rms / 4,))
    assert fit.r2 == pytest.approx((1 - rms**2 / 1.25,))


def test_samples_that_are_not_known_do_not_count() -> None:
    rng = np.random.default_rng(1)
    measured, computed = rng.normal(size=(2, 30, 2))
    expected = goodness_of_fit(measured[:20], computed[:20])
    measured[20:25], computed[25:] = np.nan, np.nan
    assert goodness_of_fit(measured, computed) == expected


LIBRARY = library()


def test_effects_on_all_or_some_joints_are_parsed() -> None:
    terms = parse_terms(["stribeck", "torque_offset:2"], LIBRARY, building.record(2))
    assert [(term.name, term.joints) for term in terms] == [("stribeck", (0, 1)), ("torque_offset", (1,))]


def test_without_numbers_an_effect_is_on_the_joints_that_can_have_it() -> None:
    axes = Rig(name="bench", mechanism="axes", axes=(Axis(), Axis(type="prismatic"), Axis(gravity=True)))
    recording = replace(building.record(3), rig=axes)
    assert parse_terms(["axis_weight"], LIBRARY, recording)[0].joints == (0,)
    with pytest.raises(BadInput, match=r"cannot be on joint 2: On a prismatic joint weight is a torque_offset\."):
        parse_terms(["axis_weight:1,2"], LIBRARY, recording)
    with pytest.raises(BadInput, match=r"on joint 3: The rig file declares the weight"):
        parse_terms(["axis_weight:3"], LIBRARY, recording)


@pytest.mark.parametrize(
    ("choices", "message"),
    [
        (["stribek"], "a name of the library expected, 'stribek' found; did you mean stribeck?"),
        (["qqq"], "'qqq' found; `ident effects` lists them"),
        (["stribeck", "stribeck:1"], "every effect once expected, 'stribeck' found twice"),
        (["air_drag"], "mechanism delta expected, axes found"),
        (["amplifier_saturation"], "cannot be seen in such a recording"),
        (["temperature_friction"], "No temperature was recorded"),
        (["stribeck:3"], "joints 1 to 2, such as stribeck:1,2, expected, '3' found"),
        (["stribeck:1,1"], "'1,1' found"),
        (["stribeck:a"], "'a' found"),
    ],
)
def test_wrong_choice_is_refused(choices: list[str], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        parse_terms(choices, LIBRARY, building.record(2))
